"""`StereoRcnnDetector`: the network between a camera's pixels and KITTI's boxes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import torch
from torch import Tensor
from torch.nn.utils.rnn import pad_sequence

from avsec_gym.argument_checks import instance_or_none, seed_number
from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import SensorFrame
from avsec_gym.perception.detectors.network_detector import NetworkDetector
from avsec_gym.perception.detectors.stereo_rcnn.alignment import Alignment
from avsec_gym.perception.detectors.stereo_rcnn.configuration import (
    RESNET101,
    StereoRcnnConfiguration,
)
from avsec_gym.perception.detectors.stereo_rcnn.decoding import (
    EVIDENCE,
    EvidencedBoxes,
    keypoint_certainty,
    observed_boxes,
    select,
    solved_boxes,
)
from avsec_gym.perception.detectors.stereo_rcnn.decoding_rule import StereoRcnnDecodingRule
from avsec_gym.perception.detectors.stereo_rcnn.dense_alignment import NetworkPixels
from avsec_gym.perception.detectors.stereo_rcnn.editions import preset_of_weights
from avsec_gym.perception.detectors.stereo_rcnn.fit import fit_loss, fit_targets
from avsec_gym.perception.detectors.stereo_rcnn.heads import KeypointOutput, PairBoxOutput
from avsec_gym.perception.detectors.stereo_rcnn.keypoints import StereoTruth, stereo_truth
from avsec_gym.perception.detectors.stereo_rcnn.losses import (
    FIT,
    TermWeights,
    detection_terms,
)
from avsec_gym.perception.detectors.stereo_rcnn.network import StereoRcnnNetwork
from avsec_gym.perception.detectors.stereo_rcnn.stereo_camera import StereoCamera
from avsec_gym.perception.detectors.stereo_rcnn.stereo_rpn import StereoRpnOutput
from avsec_gym.perception.detectors.stereo_rcnn.targets import PairSamples, draw_sampling
from avsec_gym.perception.nn.feature_pyramid import FeaturePyramid
from avsec_gym.perception.nn.region_counts import SampleCount
from avsec_gym.perception.stereo_batch import StereoBatch, batch_of_frames
from avsec_gym.perception.weights.edition import chosen_edition
from avsec_gym.perception.weights.given import Weights

_SMALL_SAMPLE = SampleCount(anchors=256, regions=64)


class StereoRcnnDetector(NetworkDetector[StereoRcnnConfiguration, StereoRcnnNetwork]):
    """Stereo R-CNN (Li et al., 2019), which can be differentiated down to the pixels.

    Its `network` stands in evaluation mode and its weights are frozen; training thaws it, and the
    `term_weights` with it.

    Args:
        configuration: The configuration of the network, or a preset's name; with weights that were
            trained for an earlier edition of the preset, that edition.
        weights: A file, a ``state_dict``, ``shipped``, or None for random ones; see `give_weights`.
        rule: The rule by which regions become boxes; None: that of the configuration.
        alignment: How depths are searched; None: that of the configuration.
        sample: How much of an image `losses` takes; None: as published for `resnet101`, else less.
        seed: The seed of the sample that `losses` draws outside of training.

    Raises:
        ConfigurationError: No such preset, or the weights of another configuration.
    """

    name = "stereo_rcnn"

    def __init__(
        self,
        configuration: StereoRcnnConfiguration | str = "small",
        weights: Weights = None,
        rule: StereoRcnnDecodingRule | None = None,
        alignment: Alignment | None = None,
        sample: SampleCount | None = None,
        seed: int = 0,
    ) -> None:
        given_rule = instance_or_none("rule", rule, StereoRcnnDecodingRule)
        given_alignment = instance_or_none("alignment", alignment, Alignment)
        given_sample = instance_or_none("sample", sample, SampleCount)
        self.seed = seed_number("seed", seed)
        configuration, _ = chosen_edition(
            StereoRcnnConfiguration, configuration, weights, self.name, preset_of_weights
        )
        super().__init__(configuration, StereoRcnnNetwork, weights, configuration.name)
        published = configuration.name == RESNET101.name
        self.rule = given_rule or configuration.rule
        self.alignment = given_alignment or configuration.alignment
        self.sample = given_sample or (SampleCount() if published else _SMALL_SAMPLE)
        self.term_weights = TermWeights(configuration.fit)
        if self.card is not None:
            self.term_weights.learned(self.card.beside)
        self.term_weights.requires_grad_(False)

    def detect(self, frame: SensorFrame) -> Boxes3D:
        """The objects of a frame, best score first, with `box2d` and `alpha`.

        Raises:
            DataError: An image of the frame's pair is missing or broken.
        """
        return self.detect_batch(batch_of_frames([frame]))[0]

    def detect_batch(self, batch: StereoBatch) -> list[Boxes3D]:
        """The objects of each pair; 2D boxes are in the camera's own pixels."""
        result = []
        for found in self.evidenced(batch):
            score = self.calibration(found.boxes.score, found.evidence)
            best_first = np.argsort(-score, kind="stable")
            result.append(replace(found.boxes, score=score)[best_first])
        return result

    @torch.no_grad()
    def evidenced(self, batch: StereoBatch) -> list[EvidencedBoxes]:
        """The objects of each pair with the network's own scores, and what else speaks for them."""
        left, right = self.prepare(batch)
        size = (left.shape[-2], left.shape[-1])
        pyramids = self.network.pair_features(left, right)
        proposals = self.network.propose(self.network.rpn(*pyramids))
        output = self.network.box_head(*pyramids, proposals.left, proposals.right)
        selected = select(proposals, output, size, self.rule)
        regions = pad_sequence([pairs.regions for pairs in selected], batch_first=True)
        if not regions.shape[1]:
            nothing = EvidencedBoxes(Boxes3D.empty(), np.zeros((0, len(EVIDENCE))))
            return [nothing for _ in selected]
        keypoints = self.network.keypoint_head(pyramids[0], regions)
        result = []
        for i, (pairs, camera) in enumerate(zip(selected, _cameras(batch), strict=True)):
            observed = observed_boxes(pairs, keypoints, i, size, camera)
            found = solved_boxes(
                observed,
                pairs.scores.double().cpu().numpy(),
                keypoint_certainty(keypoints, i, len(pairs.scores)),
                [self.configuration.categories[label - 1] for label in pairs.classes.tolist()],
                (_pixels(batch.left[i]), _pixels(batch.right[i])),
                camera,
                self.alignment,
            )
            boxes = _in_camera_pixels(found.boxes, camera.size, batch.size)
            result.append(replace(found, boxes=boxes))
        return result

    def losses(
        self,
        batch: StereoBatch,
        truth: Sequence[Boxes3D],
        disparity: Tensor | None = None,
        sampling: PairSamples | None = None,
    ) -> dict[str, Tensor]:
        """The six weighted terms (`avsec_gym.perception.detectors.stereo_rcnn.losses.TERMS`).

        And `fit`, where the configuration has it.  See `DifferentiableDetector.losses`; no term
        needs disparity.

        Args:
            batch: B pairs.
            truth: What is really there, for each pair.
            disparity: An argument of the interface that is not used.
            sampling: Proposals and samples as `draw` gave them, which makes the loss a smooth
                function of the pixels; drawn anew if None.
        """
        pyramids, rpn, sampling = self._run(batch, truth, sampling)
        boxes, keypoints, targets = self._heads(pyramids, sampling)
        background_sizes = self.configuration.background_sizes
        terms = detection_terms(rpn, boxes, keypoints, sampling, targets, background_sizes)
        if boxes.fit_logits is not None:
            wanted = sampling.fit_targets
            if wanted is None:
                wanted = self._fit_targets(batch, truth, rpn, boxes, keypoints, sampling)
            terms[FIT] = fit_loss(boxes.fit_logits, wanted)
        weighted: dict[str, Tensor] = self.term_weights(terms)
        return weighted

    @torch.no_grad()
    def draw(self, batch: StereoBatch, truth: Sequence[Boxes3D]) -> PairSamples:
        """The proposals, samples and targets that `losses` would take for these pixels."""
        pyramids, rpn, sampling = self._run(batch, truth, None)
        if not self.configuration.fit:
            return sampling
        boxes, keypoints, _ = self._heads(pyramids, sampling)
        fit = self._fit_targets(batch, truth, rpn, boxes, keypoints, sampling)
        return replace(sampling, fit_targets=fit)

    def prepare(self, batch: StereoBatch) -> tuple[Tensor, Tensor]:
        """Both images as the network takes them: scaled, its order of channels, normalised."""
        weight = next(self.network.parameters())
        height, width = batch.left.shape[-2:]
        batch = batch.to(weight.device).resized(*self.configuration.size_for(height, width))
        mean, deviation = (
            weight.new_tensor(values)[:, None, None]
            for values in (self.configuration.mean, self.configuration.deviation)
        )
        channels = [2, 1, 0] if self.configuration.blue_first else [0, 1, 2]
        left, right = (
            (images.to(weight.dtype)[:, channels] - mean) / deviation
            for images in (batch.left, batch.right)
        )
        return left, right

    def _run(
        self, batch: StereoBatch, truth: Sequence[Boxes3D], sampling: PairSamples | None
    ) -> tuple[tuple[FeaturePyramid, FeaturePyramid], StereoRpnOutput, PairSamples]:
        left, right = self.prepare(batch)
        pyramids = self.network.pair_features(left, right)
        rpn = self.network.rpn(*pyramids)
        if sampling is None:
            truths = self._truths(batch, truth, rpn)
            # Training draws from torch's own generator; whatever attacks gets the same each time.
            own = None if self.network.training else torch.Generator().manual_seed(self.seed)
            proposals = self.network.propose(rpn)
            sampling = draw_sampling(rpn, proposals, truths, self.sample, own)
        return pyramids, rpn, sampling

    def _heads(
        self, pyramids: tuple[FeaturePyramid, FeaturePyramid], sampling: PairSamples
    ) -> tuple[PairBoxOutput, KeypointOutput, Tensor]:
        """The heads' output for the sampled regions, and the keypoints that are their targets."""
        boxes = self.network.box_head(*pyramids, sampling.left, sampling.right)
        # Keypoints of the background teach nothing, and cost most.
        regions, targets = sampling.with_keypoints()
        return boxes, self.network.keypoint_head(pyramids[0], regions), targets

    def _truths(
        self, batch: StereoBatch, truth: Sequence[Boxes3D], rpn: StereoRpnOutput
    ) -> list[StereoTruth]:
        """What is learned of each pair, in pixels of the network's input."""
        height, width = batch.left.shape[-2:]
        scale = rpn.height / height, rpn.width / width
        return [
            stereo_truth(boxes, camera, self.configuration.categories).resized(*scale)
            for boxes, camera in zip(truth, _cameras(batch), strict=True)
        ]

    def _fit_targets(
        self,
        batch: StereoBatch,
        truth: Sequence[Boxes3D],
        rpn: StereoRpnOutput,
        boxes: PairBoxOutput,
        keypoints: KeypointOutput,
        sampling: PairSamples,
    ) -> Tensor:
        truths, size = self._truths(batch, truth, rpn), (rpn.height, rpn.width)
        return fit_targets(boxes, keypoints, sampling, truths, _cameras(batch), size)


def _cameras(batch: StereoBatch) -> list[StereoCamera]:
    """Of the batch's own pixels."""
    size = (batch.left.shape[-2], batch.left.shape[-1])
    pairs = zip(batch.left_projection, batch.right_projection, strict=True)
    return [
        StereoCamera.of_projections(left.cpu().numpy(), right.cpu().numpy(), size)
        for left, right in pairs
    ]


def _pixels(image: Tensor) -> NetworkPixels:
    return image.detach().permute(1, 2, 0).float().cpu().contiguous().numpy()


def _in_camera_pixels(boxes: Boxes3D, size: tuple[int, int], own: tuple[int, int]) -> Boxes3D:
    """2D boxes in images of one size, in those of the camera's own size."""
    if size == own or boxes.box2d is None:
        return boxes
    scale = np.array([own[1] / size[1], own[0] / size[0]] * 2)
    return replace(boxes, box2d=(boxes.box2d + 0.5) * scale - 0.5)
