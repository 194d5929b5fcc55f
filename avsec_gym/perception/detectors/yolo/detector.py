"""`YoloDetector`: the network between an image's pixels and 2D boxes."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor

from avsec_gym.argument_checks import instance_of
from avsec_gym.boxes import Boxes3D
from avsec_gym.perception.detectors.box_selection import SelectedBoxes, SelectionRule, select
from avsec_gym.perception.detectors.image_network_detector import ImageNetworkDetector
from avsec_gym.perception.detectors.yolo.box_coding import decoded_boxes
from avsec_gym.perception.detectors.yolo.configuration import YoloConfiguration
from avsec_gym.perception.detectors.yolo.losses import detection_terms
from avsec_gym.perception.detectors.yolo.network import YoloNetwork, YoloOutput
from avsec_gym.perception.detectors.yolo.targets import YoloTargets, find_targets
from avsec_gym.perception.nn.box_coding import clip_boxes
from avsec_gym.perception.presets import chosen_configuration
from avsec_gym.perception.weights.given import Weights


class YoloDetector(ImageNetworkDetector[YoloConfiguration, YoloNetwork]):
    """Cars in an image by YOLOv3, differentiable down to the pixels.

    Args:
        configuration: The configuration of the network, or a preset's name.
        weights: A file, a ``state_dict``, ``shipped``, or None for random ones; see `give_weights`.
        rule: The rule by which boxes are detections; a box scores objectness times class
            probability.

    Raises:
        ConfigurationError: No such preset, or the weights of another configuration.
    """

    name = "yolo"

    def __init__(
        self,
        configuration: YoloConfiguration | str = "small",
        weights: Weights = None,
        rule: SelectionRule = SelectionRule(overlap=0.45),
    ) -> None:
        self.rule = instance_of("rule", rule, SelectionRule)
        configuration, _ = chosen_configuration(YoloConfiguration, configuration)
        super().__init__(configuration, YoloNetwork, weights)

    def losses(
        self, images: Tensor, truth: Sequence[Boxes3D], targets: YoloTargets | None = None
    ) -> dict[str, Tensor]:
        """The four terms; see `DifferentiableImageDetector.losses`.

        Args:
            images: The images, shape (B, 3, H, W).
            truth: What is really there, for each image.
            targets: The targets as `targets` gave them, which makes the loss a smooth function of
                the pixels; found anew if None.
        """
        output, targets = self._run(images, truth, targets)
        return detection_terms(output, targets)

    @torch.no_grad()
    def targets(self, images: Tensor, truth: Sequence[Boxes3D]) -> YoloTargets:
        """What `losses` would hold the network's boxes against for these pixels."""
        return self._run(images, truth, None)[1]

    def _run(
        self, images: Tensor, truth: Sequence[Boxes3D], targets: YoloTargets | None
    ) -> tuple[YoloOutput, YoloTargets]:
        inputs = self.prepare(images)
        output: YoloOutput = self.network(inputs)
        if targets is None:
            size = (inputs.shape[2], inputs.shape[3])
            truths = self.truth(truth, images, inputs)
            targets = find_targets(output, truths, size, self.configuration)
        return output, targets

    def _found(self, inputs: Tensor) -> list[SelectedBoxes]:
        output: YoloOutput = self.network(inputs)
        boxes = clip_boxes(decoded_boxes(output), inputs.shape[2], inputs.shape[3])
        scores = output.objectness.sigmoid()[..., None] * output.classes.sigmoid()
        return [
            select(of_image[:, None], score, self.rule)
            for of_image, score in zip(boxes, scores, strict=True)
        ]
