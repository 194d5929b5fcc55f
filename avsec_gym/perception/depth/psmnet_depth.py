"""`PsmNetDepth`: PSMNet between a camera's pixels and disparities in these pixels."""

from __future__ import annotations

from dataclasses import replace

import torch
from torch import Tensor
from torch.nn import functional

from avsec_gym.argument_checks import camera_number
from avsec_gym.frame import SensorFrame
from avsec_gym.perception.depth.depth import DisparityMap, pair_scale
from avsec_gym.perception.depth.psmnet import PsmNet, PsmNetConfiguration, psmnet_loss
from avsec_gym.perception.stereo_batch import StereoBatch, batch_of_frames
from avsec_gym.perception.weights.edition import chosen_edition
from avsec_gym.perception.weights.given import (
    SHIPPED,
    Weights,
    check_weights,
    give_weights,
    shipped_weights,
)
from avsec_gym.perception.weights.model_card import ModelCard
from avsec_gym.perception.weights.recorded import recorded_corners

_MEAN, _DEVIATION = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)
"""The mean and the deviation of ImageNet's red, green and blue, as shares of 255."""
_MULTIPLE = 16


class PsmNetDepth:
    """A learned `DepthEstimator` that can be differentiated down to the pixels.

    Its `network` stands in evaluation mode and its weights are frozen; training thaws it.

    Args:
        configuration: The configuration of the network, or a preset's name: then maps are enlarged
            in the way that the weights' card records.
        weights: A file, a ``state_dict``, ``shipped``, or None for random ones; see `give_weights`.
        left: Reference camera.
        right: The other one.

    Raises:
        ConfigurationError: Another preset, a `state_dict` of another network, or weights that
            learned to enlarge maps in another way than the configuration has it.
        DataError: The file cannot be read, or is of another network.
    """

    name = "psmnet"

    def __init__(
        self,
        configuration: PsmNetConfiguration | str = "small",
        weights: Weights = None,
        left: int = 2,
        right: int = 3,
    ) -> None:
        self.left, self.right = camera_number("left", left), camera_number("right", right)
        asked = (configuration, weights)
        if all(isinstance(each, str) for each in asked) and asked == ("medium", SHIPPED):
            # The same network at another size: what the package ships for `small` is its, too.
            weights = shipped_weights(f"{self.name}_small")
        self.configuration, preset = chosen_edition(
            PsmNetConfiguration, configuration, weights, self.name, _preset_of_weights
        )
        check_weights(weights, f"{self.name}_{preset}")
        self.network = PsmNet(self.configuration)
        give_weights(self.network, weights, f"{self.name}_{preset}")

    def disparity(self, frame: SensorFrame) -> DisparityMap:
        """See `DepthEstimator`."""
        batch = batch_of_frames([frame], self.left, self.right)
        values = self.disparity_batch(batch)[0].float().cpu().numpy()
        return DisparityMap(values, pair_scale(frame, self.left, self.right))

    def disparity_batch(self, batch: StereoBatch) -> Tensor:
        """Disparities of the left images, shape (B, H, W), in their pixels, without gradient."""
        height, width = batch.left.shape[-2:]
        with torch.no_grad():
            found = self._run(batch)[-1]
        size = (height, width)
        enlarged = functional.interpolate(
            found[:, None], size=size, mode="bilinear", align_corners=False
        )
        return enlarged[:, 0] * (width / found.shape[-1])

    def losses(self, batch: StereoBatch, disparity: Tensor) -> dict[str, Tensor]:
        """The training loss, with gradient to the pixels: the term ``disparity``.

        Args:
            batch: B pairs, grey levels 0..255.
            disparity: The disparities of the left images, in their pixels, shape (B, H, W), 0 where
                unknown.
        """
        found = self._run(batch)
        size = (found[-1].shape[-2], found[-1].shape[-1])
        truth = disparity.to(found[-1])
        if truth.shape[-2:] != size:
            # The nearest value: a mean would lie between an object and what is behind it.
            scale = size[1] / truth.shape[-1]
            truth = functional.interpolate(truth[:, None], size=size, mode="nearest-exact")[:, 0]
            truth = truth * scale
        return {"disparity": psmnet_loss(found, truth, self.configuration.disparities)}

    def _run(self, batch: StereoBatch) -> list[Tensor]:
        """Disparities at the network's size, in its pixels."""
        weight = next(self.network.parameters())
        batch = batch.to(weight.device)
        if self.configuration.input_size is not None:
            batch = batch.resized(*self.configuration.input_size)
        height, width = batch.left.shape[-2:]
        above, beside = -height % _MULTIPLE, -width % _MULTIPLE
        mean, deviation = (
            255 * batch.left.new_tensor(values)[:, None, None] for values in (_MEAN, _DEVIATION)
        )
        left, right = (
            functional.pad((images - mean) / deviation, (0, beside, above, 0)).to(weight.dtype)
            for images in (batch.left, batch.right)
        )
        return [found[:, above:, :width] for found in self.network(left, right)]


def _preset_of_weights(name: str, card: ModelCard | None) -> PsmNetConfiguration:
    """A preset that enlarges maps as the network of the weights did."""
    configuration = PsmNetConfiguration.preset(name)
    features = configuration.features
    of_means = recorded_corners(card, "features.aligned_corners", features.aligned_corners)
    of_costs = recorded_corners(card, "aligned_corners", configuration.aligned_corners)
    return replace(
        configuration,
        aligned_corners=of_costs,
        features=replace(features, aligned_corners=of_means),
    )
