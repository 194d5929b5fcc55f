"""`DsgnDetector`: the network between a camera's pixels and KITTI's boxes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional

from avsec_gym.argument_checks import instance_or_none, shown
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats
from avsec_gym.perception.detectors.dsgn.configuration import DsgnConfiguration
from avsec_gym.perception.detectors.dsgn.decoding import decode
from avsec_gym.perception.detectors.dsgn.decoding_rule import DsgnDecodingRule
from avsec_gym.perception.detectors.dsgn.depth_losses import depth_loss, on_objects, plane_loss
from avsec_gym.perception.detectors.dsgn.editions import preset_of_weights
from avsec_gym.perception.detectors.dsgn.fit import fit_loss
from avsec_gym.perception.detectors.dsgn.losses import detection_losses
from avsec_gym.perception.detectors.dsgn.network import DsgnNetwork, DsgnOutput
from avsec_gym.perception.detectors.dsgn.targets import (
    AnchorTargets,
    anchor_targets,
    objects_to_learn,
)
from avsec_gym.perception.detectors.network_detector import NetworkDetector
from avsec_gym.perception.stereo_batch import StereoBatch, batch_of_frames
from avsec_gym.perception.weights.edition import chosen_edition
from avsec_gym.perception.weights.given import Weights

_MEAN = (0.485, 0.456, 0.406)
_DEVIATION = (0.229, 0.224, 0.225)
"""Deviation of ImageNet's red, green and blue, as shares of 255."""
_MULTIPLE = 16
"""Image sides that the network can halve and double without loss."""


@dataclass(frozen=True, eq=False)
class NetworkInput:
    """What `DsgnNetwork` takes of B pairs; h x w pixels of image, padded to H x W.

    Args:
        left: Normalised, shape (B, 3, H, W).
        right: The same shape.
        projection: P of the left camera for these pixels, shape (B, 3, 4).
        focal_times_baseline: Depth times disparity, metres x these pixels, shape (B,).
        image_size: h and w.
    """

    left: Tensor
    right: Tensor
    projection: Tensor
    focal_times_baseline: Tensor
    image_size: tuple[int, int]


class DsgnDetector(NetworkDetector[DsgnConfiguration, DsgnNetwork]):
    """DSGN (Chen et al., 2020), a stereo detector that can be differentiated down to the pixels.

    Its `network` stands in evaluation mode and its weights are frozen; training thaws it.

    Args:
        configuration: The configuration of the network, or a preset's name; with weights that were
            trained for an earlier edition of the preset, that edition.
        weights: A file, a ``state_dict``, ``shipped``, or None for random ones; see `give_weights`.
        categories: Classes that `losses` teaches, among those of the anchors.
        rule: The rule by which anchors become boxes; None: that of the configuration.

    Raises:
        ConfigurationError: The weights are those of another configuration, or no anchor has one
            of the categories.
    """

    name = "dsgn"

    def __init__(
        self,
        configuration: DsgnConfiguration | str = "small",
        weights: Weights = None,
        categories: Sequence[str] = ("Car",),
        rule: DsgnDecodingRule | None = None,
    ) -> None:
        given_rule = instance_or_none("rule", rule, DsgnDecodingRule)
        configuration, preset = chosen_edition(
            DsgnConfiguration, configuration, weights, self.name, preset_of_weights
        )
        known = [anchor.category for anchor in configuration.anchors]
        is_list = isinstance(categories, list | tuple) and len(categories) > 0
        if not (is_list and all(isinstance(each, str) and each in known for each in categories)):
            raise ConfigurationError(f"categories takes some of {known}, got {shown(categories)}")
        super().__init__(configuration, DsgnNetwork, weights, preset)
        self.categories = tuple(categories)
        self.rule = given_rule or configuration.rule

    def detect(self, frame: SensorFrame) -> Boxes3D:
        """The objects of a frame, best score first, with `box2d` and `alpha`.

        Raises:
            DataError: An image of the frame's pair is missing or broken.
        """
        return self.detect_batch(batch_of_frames([frame]))[0]

    def detect_batch(self, batch: StereoBatch) -> list[Boxes3D]:
        """The objects of each pair; 2D boxes are in the camera's own pixels."""
        with torch.no_grad():
            output, _ = self._run(batch)
        projections = _camera_projections(batch)
        found = decode(output, self.configuration, projections, batch.size, self.rule)
        return [replace(boxes, score=self.calibration(boxes.score)) for boxes in found]

    @property
    def target_maker(self) -> Callable[[Sequence[Boxes3D]], AnchorTargets]:
        """What the losses make of objects alone: may be sent to who prepares batches ahead."""
        return partial(anchor_targets, configuration=self.configuration, categories=self.categories)

    def losses(
        self,
        batch: StereoBatch,
        truth: Sequence[Boxes3D],
        disparity: Tensor | None = None,
        targets: AnchorTargets | None = None,
    ) -> dict[str, Tensor]:
        """The terms `depth` (with disparity only), `classification`, `box` and `centerness`.

        And, where the configuration has them, `reversal` and `fit`.  See
        `DifferentiableDetector.losses`.

        Args:
            batch: The pairs.
            truth: The objects of each.
            disparity: The disparities of the left images.
            targets: What `target_maker` makes of the objects, if it is there already.
        """
        output, given = self._run(batch)
        targets = self.target_maker(truth) if targets is None else targets
        terms = detection_losses(output, targets)
        if output.fit is not None:
            terms["fit"] = fit_loss(output, truth, targets, self.configuration, self.categories)
        if disparity is not None:
            true_depth = _true_depth(batch, disparity.to(given.left), given)
            terms = {"depth": self._depth_loss(output, given, true_depth, truth), **terms}
        return terms

    def _depth_loss(
        self, output: DsgnOutput, given: NetworkInput, true_depth: Tensor, truth: Sequence[Boxes3D]
    ) -> Tensor:
        """By the configuration, against depths of shape (B, H, W), 0 where unknown."""
        c = self.configuration
        if c.depth_loss == "expectation":
            near, far = sorted((c.grid.z.start, c.grid.z.stop))
            return depth_loss(output.depth, true_depth, near, far)
        # Feature i stands at pixel 4 i.
        step = true_depth.shape[-1] // output.depth_logits.shape[-1]
        true_depth = true_depth[:, ::step, ::step]
        objects = [objects_to_learn(boxes, c, self.categories)[0] for boxes in truth]
        shown = on_objects(true_depth, given.projection, objects, step)
        weight = torch.where(shown, c.object_pixels, 1.0).to(true_depth)
        return plane_loss(output.depth_logits, output.depth_bins, true_depth, weight)

    def prepare(self, batch: StereoBatch) -> NetworkInput:
        """Scaled, normalised, padded with zeros at the right and below, in the network's type."""
        weight = next(self.network.parameters())
        batch = batch.to(weight.device)
        if self.configuration.input_size is not None:
            batch = batch.resized(*self.configuration.input_size)
        height, width = batch.left.shape[-2:]
        sides = zip((height, width), self.configuration.padded_size, strict=True)
        below, beside = (
            max(padded, -(-side // _MULTIPLE) * _MULTIPLE) - side for side, padded in sides
        )
        mean, deviation = (
            255 * batch.left.new_tensor(values)[:, None, None] for values in (_MEAN, _DEVIATION)
        )
        left, right = (
            functional.pad((images - mean) / deviation, (0, beside, 0, below)).to(weight.dtype)
            for images in (batch.left, batch.right)
        )
        return NetworkInput(
            left,
            right,
            batch.left_projection.to(left),
            (batch.focal_length * batch.baseline).to(left),
            (height, width),
        )

    def _run(self, batch: StereoBatch) -> tuple[DsgnOutput, NetworkInput]:
        given = self.prepare(batch)
        output = self.network(given.left, given.right, given.projection, given.focal_times_baseline)
        return output, given


def _camera_projections(batch: StereoBatch) -> Floats:
    """P of the left cameras for their own pixels, shape (B, 3, 4): `resized` undone."""
    height, width = batch.left.shape[-2:]
    u, v = batch.size[1] / width, batch.size[0] / height
    change = np.array([[u, 0, (u - 1) / 2], [0, v, (v - 1) / 2], [0, 0, 1]])
    return np.asarray(change @ batch.left_projection.double().cpu().numpy())


def _true_depth(batch: StereoBatch, disparity: Tensor, given: NetworkInput) -> Tensor:
    """Metres at the network's pixels, shape (B, H, W); 0 where unknown and in the padding."""
    scale = (batch.focal_length * batch.baseline).to(disparity)[:, None, None]
    known = disparity > 0  # Also false for NaN.
    depth = torch.where(known, scale / torch.where(known, disparity, 1.0), 0.0)
    # The nearest value: a mean would lie between an object and what is behind it.
    depth = functional.interpolate(depth[:, None], size=given.image_size, mode="nearest-exact")
    height, width = given.image_size
    below, beside = given.left.shape[-2] - height, given.left.shape[-1] - width
    return functional.pad(depth[:, 0], (0, beside, 0, below))
