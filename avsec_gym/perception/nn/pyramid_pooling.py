"""Image features with spatial pyramid pooling, as PSMNet and DSGN both extract them.

A residual trunk down to a quarter of the image, means over windows of several sizes (He et al.,
2015) laid beside its stages, and one head that makes features to match, and in DSGN a second one
that makes features of meaning.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor, nn
from torch.nn import functional

from avsec_gym.errors import ConfigurationError
from avsec_gym.perception.nn.convolution import convolutions
from avsec_gym.perception.nn.residual import residual_stage

STRIDE = 4
"""Pixels of an image between two of its features."""


@dataclass(frozen=True)
class FeatureConfiguration:
    """The widths and lengths of a `FeatureExtraction`."""

    first: int = 32
    """Channels of the three first convolutions, at half the size of the image."""
    stages: tuple[tuple[int, int], ...] = ((32, 3), (64, 16), (128, 3), (128, 3))
    """Channels and residual blocks of the four stages; from the second on at a quarter."""
    joined: tuple[int, ...] = (2, 4)
    """Which stages, counted from 1, the heads see beside the pooled means."""
    windows: tuple[tuple[int, int], ...] = ((64, 64), (32, 32), (16, 16), (8, 8))
    """Height and width of the means over the last stage, in its pixels, largest first."""
    pooled: int = 32
    """Channels of each mean."""
    pyramid: bool = True
    """Off: zeros stand for the means, so that the same weights run with and without them."""
    aligned_corners: bool = False
    """How the means are enlarged: whether the corners' centres stay where they are."""
    matching: tuple[int, int] = (128, 32)
    """Channels of the two convolutions of the head whose features are matched."""
    semantic: tuple[int, int] | None = None
    """The same of the head for meaning; none where a network has no such head."""
    groups: int = 0
    """Groups of normalised channels, see `normalisation`."""

    def __post_init__(self) -> None:
        if len(self.stages) != 4 or not set(self.joined) <= {2, 3, 4}:
            raise ConfigurationError(
                f"a trunk has four stages, of which 2, 3 and 4 can be joined, got {self}"
            )


class FeatureExtraction(nn.Module):
    """The images' features at a quarter of their size."""

    def __init__(self, configuration: FeatureConfiguration) -> None:
        super().__init__()
        self.configuration = configuration
        groups, first = configuration.groups, configuration.first
        (one, blocks1), (two, blocks2), (three, blocks3), (four, blocks4) = configuration.stages
        self.firstconv = convolutions(3, first, first, first, groups=groups, stride=2)
        self.layer1 = residual_stage(first, one, blocks1, groups=groups)
        self.layer2 = residual_stage(one, two, blocks2, groups=groups, stride=2)
        self.layer3 = residual_stage(two, three, blocks3, groups=groups)
        self.layer4 = residual_stage(three, four, blocks4, groups=groups, dilation=2)
        self._branches = [f"branch{i + 1}" for i in range(len(configuration.windows))]
        for name, window in zip(self._branches, configuration.windows, strict=True):
            reduced = convolutions(four, configuration.pooled, groups=groups, kernel=1)
            self.add_module(name, nn.Sequential(nn.AvgPool2d(window), *reduced))
        joined = sum(configuration.stages[stage - 1][0] for stage in configuration.joined)
        joined += configuration.pooled * len(configuration.windows)
        middle, out = configuration.matching
        self.lastconv = nn.Sequential(
            *convolutions(joined, middle, groups=groups), nn.Conv2d(middle, out, 1, bias=False)
        )
        if configuration.semantic is not None:
            self.rpnconv = convolutions(joined, *configuration.semantic, groups=groups)

    def forward(self, images: Tensor) -> Tensor:
        """What the heads see: (B, 3, H, W) to (B, channels of all joined, H/4, W/4)."""
        features = {2: self.layer2(self.layer1(self.firstconv(images)))}
        features[3] = self.layer3(features[2])
        features[4] = self.layer4(features[3])
        means = [self._mean(name, features[4]) for name in reversed(self._branches)]
        return torch.cat([*(features[stage] for stage in self.configuration.joined), *means], 1)

    def _mean(self, branch: str, features: Tensor) -> Tensor:
        size = features.shape[-2:]
        if not self.configuration.pyramid:
            return features.new_zeros(len(features), self.configuration.pooled, *size)
        return functional.interpolate(
            self.get_submodule(branch)(features),
            size=size,
            mode="bilinear",
            align_corners=self.configuration.aligned_corners,
        )
