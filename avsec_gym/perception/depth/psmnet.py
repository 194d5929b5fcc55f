"""PSMNet (Chang & Chen, CVPR 2018, stacked hourglasses): disparity of every pixel.

The names of the network's parts are those of the original's ``state_dict``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import torch
from torch import Tensor, nn
from torch.nn import functional

from avsec_gym.errors import ConfigurationError
from avsec_gym.perception.nn.convolution import (
    VolumeConvolution,
    convolution,
    convolutions,
    initialise,
)
from avsec_gym.perception.nn.cost_volume import disparity_volume, enlarged, expectation
from avsec_gym.perception.nn.hourglass import Hourglass
from avsec_gym.perception.nn.pyramid_pooling import (
    STRIDE,
    FeatureConfiguration,
    FeatureExtraction,
)
from avsec_gym.perception.presets import preset_named

_FEATURES = FeatureConfiguration()


@dataclass(frozen=True)
class PsmNetConfiguration:
    """The architecture; the defaults are the original's.

    Raises:
        ConfigurationError: Numbers that do not fit together, or an unknown preset.
    """

    input_size: tuple[int, int] | None = None
    """Height and width that images are scaled to, multiples of 16; None leaves them as they are
    (padded at the top and at the right to multiples of 16)."""
    disparities: int = 192
    """Whole disparities 0, 1, ... in pixels of the input; a multiple of 16."""
    features: FeatureConfiguration = _FEATURES
    volume_channels: int = 32
    groups: int = 0
    """Groups of normalised channels in the volume, see `normalisation`."""
    disparity_step: int = 1
    """The step between the disparities whose expectation is taken: 1, costs are interpolated
    between the planes of the volume; 4, those planes."""
    aligned_corners: bool = False
    """How costs are enlarged to the image: whether the centres of the outermost cells stay where
    they are, as in the release of torch that the published weights were trained with.  Weights
    that learned the one are a pixel wrong with the other.  `features` has its own, see
    `with_corners`."""

    def __post_init__(self) -> None:
        sizes = (self.disparities, *(self.input_size or ()))
        if any(size <= 0 or size % 16 for size in sizes):
            raise ConfigurationError(f"disparities and sizes must be multiples of 16, got {sizes}")
        if self.disparity_step not in (1, 2, STRIDE):
            raise ConfigurationError(f"disparity_step is 1, 2 or 4, got {self.disparity_step}")

    @classmethod
    def preset(cls, name: str) -> PsmNetConfiguration:
        """``full`` (the original), ``small``, or ``medium``: it, on images half as large again."""
        return preset_named("PSMNet", name, _PRESETS)

    def with_corners(self, aligned: bool) -> PsmNetConfiguration:
        """The same network, whose costs and pooled means are enlarged in this way."""
        features = replace(self.features, aligned_corners=aligned)
        return replace(self, aligned_corners=aligned, features=features)


class PsmNet(nn.Module):
    """Image features, their concatenation at every disparity, three hourglasses one upon the other.

    Images are normalised by ImageNet's mean and deviation; their sizes are multiples of 16.
    """

    def __init__(self, configuration: PsmNetConfiguration) -> None:
        super().__init__()
        self.configuration = configuration
        self.feature_extraction = FeatureExtraction(configuration.features)
        pair, wide = 2 * configuration.features.matching[1], configuration.volume_channels
        groups = configuration.groups

        def row(*channels: int) -> nn.Sequential:
            return convolutions(*channels, groups=groups, dimensions=3)

        def hourglass() -> Hourglass:
            return Hourglass(wide, groups=groups, dimensions=3)

        def head() -> nn.Sequential:
            return nn.Sequential(
                *row(wide, wide), VolumeConvolution(wide, 1, 3, padding=1, bias=False)
            )

        # Names and order of the original: convolutions, three hourglasses, a head behind each.
        self.dres0 = row(pair, wide, wide)
        self.dres1 = nn.Sequential(
            *row(wide, wide), convolution(wide, wide, groups=groups, dimensions=3)
        )
        self.dres2, self.dres3, self.dres4 = hourglass(), hourglass(), hourglass()
        self.classif1, self.classif2, self.classif3 = head(), head(), head()
        initialise(self)

    def forward(self, left: Tensor, right: Tensor) -> list[Tensor]:
        """Disparities in pixels of the input, each of shape (B, H, W).

        Args:
            left: Normalised, shape (B, 3, H, W).
            right: The same shape.

        Returns:
            In training, one behind each hourglass, the last the best; otherwise the last alone.
        """
        features, right_features = self.matching_features(torch.cat([left, right])).chunk(2)
        planes = self.configuration.disparities // STRIDE
        volume = self.dres0(disparity_volume(features, right_features, planes))
        volume = volume + self.dres1(volume)
        first, down, up = self.dres2(volume)
        first = first + volume
        second, _, second_up = self.dres3(first, down, up)
        second = second + volume
        third, _, _ = self.dres4(second, down, second_up)
        third = third + volume
        costs = [self.classif1(first)]
        costs.append(self.classif2(second) + costs[-1])
        costs.append(self.classif3(third) + costs[-1])
        seen = costs if self.training else costs[-1:]
        return [self._disparity(cost, left.shape[-2:]) for cost in seen]

    def matching_features(self, images: Tensor) -> Tensor:
        """What both views are compared by: (B, 3, H, W) to (B, C, H/4, W/4)."""
        matching: Tensor = self.feature_extraction.lastconv(self.feature_extraction(images))
        return matching

    def _disparity(self, cost: Tensor, size: Sequence[int]) -> Tensor:
        """The expectation over all disparities."""
        step, aligned = self.configuration.disparity_step, self.configuration.aligned_corners
        count = self.configuration.disparities // step
        logits = enlarged(cost[:, 0], (count, *size), aligned_corners=aligned)
        number = torch.arange(count).to(cost)
        if aligned:
            # The first stands for disparity 0, the last for the largest, however many there are.
            return expectation(
                logits, number * ((self.configuration.disparities - 1) / (count - 1))
            )
        return expectation(logits, (number + 0.5) * step - 0.5)


def psmnet_loss(
    predicted: Sequence[Tensor],
    truth: Tensor,
    disparities: int,
    weights: Sequence[float] = (0.5, 0.7, 1.0),
) -> Tensor:
    """Smooth L1 distance of every prediction from the truth, weighted (section 4.2).

    Args:
        predicted: The predictions of `PsmNet.forward`, each of shape (B, H, W); with fewer than the
            weights, the last weights count.
        truth: The true disparities, pixels of the input, 0 where unknown, shape (B, H, W).
        disparities: The number of disparities of the configuration; larger ones cannot be found and
            do not count.
        weights: The weights of the predictions.

    Returns:
        A scalar; 0 where no pixel is known.
    """
    known = (truth > 0) & (truth < disparities)
    count = known.sum().clamp(min=1)
    losses = [
        weight * functional.smooth_l1_loss(disparity[known], truth[known], reduction="sum") / count
        for weight, disparity in zip(weights[-len(predicted) :], predicted, strict=True)
    ]
    return torch.stack(losses).sum()


_FULL = PsmNetConfiguration()
_SMALL = PsmNetConfiguration(
    input_size=(208, 688),
    disparities=112,  # as many for 688 columns as 202 for KITTI's 1242
    disparity_step=4,
    features=FeatureConfiguration(
        first=16,
        stages=((16, 1), (32, 3), (48, 1), (48, 1)),
        windows=((40, 33), (20, 22), (10, 11), (5, 6)),
        pooled=8,
        matching=(32, 8),
    ),
    volume_channels=8,
)
_MEDIUM = replace(_SMALL, input_size=(240, 784), disparities=128)
_PRESETS = {"full": _FULL, "small": _SMALL, "medium": _MEDIUM}
