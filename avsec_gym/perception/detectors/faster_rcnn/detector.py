"""`FasterRcnnDetector`: the network between an image's pixels and 2D boxes."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor

from avsec_gym.argument_checks import instance_of, instance_or_none, seed_number
from avsec_gym.boxes import Boxes3D
from avsec_gym.perception.detectors.box_selection import SelectedBoxes, SelectionRule, select
from avsec_gym.perception.detectors.faster_rcnn.configuration import FasterRcnnConfiguration
from avsec_gym.perception.detectors.faster_rcnn.losses import detection_terms
from avsec_gym.perception.detectors.faster_rcnn.network import FasterRcnnNetwork
from avsec_gym.perception.detectors.faster_rcnn.region_proposals import RpnOutput
from avsec_gym.perception.detectors.faster_rcnn.targets import (
    BOX_DEVIATIONS,
    RegionSamples,
    draw_sampling,
)
from avsec_gym.perception.detectors.image_network_detector import ImageNetworkDetector
from avsec_gym.perception.nn.box_coding import clip_boxes, decode_boxes
from avsec_gym.perception.nn.feature_pyramid import FeaturePyramid
from avsec_gym.perception.nn.region_counts import SampleCount
from avsec_gym.perception.presets import chosen_configuration
from avsec_gym.perception.weights.given import Weights

_PUBLISHED_SAMPLE = SampleCount(anchors=256, regions=512)
_SMALL_SAMPLE = SampleCount(anchors=256, regions=96)


class FasterRcnnDetector(ImageNetworkDetector[FasterRcnnConfiguration, FasterRcnnNetwork]):
    """Cars in an image by Faster R-CNN, differentiable down to the pixels.

    Args:
        configuration: The configuration of the network, or a preset's name.
        weights: A file, a ``state_dict``, ``shipped``, or None for random ones; see `give_weights`.
        rule: The rule by which regions become boxes.
        sample: How much of an image `losses` takes; None: less for `small` than as published.
        seed: The seed of the sample that `losses` draws outside of training.

    Raises:
        ConfigurationError: No such preset, or the weights of another configuration.
    """

    name = "faster_rcnn"

    def __init__(
        self,
        configuration: FasterRcnnConfiguration | str = "small",
        weights: Weights = None,
        rule: SelectionRule = SelectionRule(),
        sample: SampleCount | None = None,
        seed: int = 0,
    ) -> None:
        self.rule = instance_of("rule", rule, SelectionRule)
        given_sample = instance_or_none("sample", sample, SampleCount)
        self.seed = seed_number("seed", seed)
        configuration, _ = chosen_configuration(FasterRcnnConfiguration, configuration)
        super().__init__(configuration, FasterRcnnNetwork, weights)
        is_small = configuration.name == "small"
        self.sample = given_sample or (_SMALL_SAMPLE if is_small else _PUBLISHED_SAMPLE)

    def losses(
        self, images: Tensor, truth: Sequence[Boxes3D], sampling: RegionSamples | None = None
    ) -> dict[str, Tensor]:
        """The four terms; see `DifferentiableImageDetector.losses`.

        Args:
            images: The images, shape (B, 3, H, W).
            truth: What is really there, for each image.
            sampling: Proposals and samples as `draw` gave them, which makes the loss a smooth
                function of the pixels; drawn anew if None.
        """
        pyramid, rpn, sampling = self._run(images, truth, sampling)
        return detection_terms(rpn, self.network.box_head(pyramid, sampling.regions), sampling)

    @torch.no_grad()
    def draw(self, images: Tensor, truth: Sequence[Boxes3D]) -> RegionSamples:
        """The proposals, samples and targets that `losses` would take for these pixels."""
        return self._run(images, truth, None)[2]

    def _run(
        self, images: Tensor, truth: Sequence[Boxes3D], sampling: RegionSamples | None
    ) -> tuple[FeaturePyramid, RpnOutput, RegionSamples]:
        inputs = self.prepare(images)
        pyramid = self.network.features(inputs)
        rpn: RpnOutput = self.network.rpn(pyramid)
        if sampling is None:
            # Training draws from torch's own generator; whatever attacks gets the same each time.
            own = None if self.network.training else torch.Generator().manual_seed(self.seed)
            truths = self.truth(truth, images, inputs)
            proposals = self.network.propose(rpn)
            sampling = draw_sampling(rpn, proposals, truths, self.sample, own)
        return pyramid, rpn, sampling

    def _found(self, inputs: Tensor) -> list[SelectedBoxes]:
        _, proposals, output = self.network(inputs)
        deltas = output.deltas * output.deltas.new_tensor(BOX_DEVIATIONS)
        boxes = decode_boxes(proposals.regions[:, :, None], deltas)
        boxes = clip_boxes(boxes, inputs.shape[2], inputs.shape[3])
        scores = output.class_logits.softmax(-1) * proposals.valid[..., None]
        return [
            select(of_image[:, 1:], score[:, 1:], self.rule)
            for of_image, score in zip(boxes, scores, strict=True)
        ]
