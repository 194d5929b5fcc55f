"""Feature pyramids (Lin et al., CVPR 2017): every level as rich as the coarsest, none coarser."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from torch import Tensor, nn
from torch.nn import functional

STRIDES = (4, 8, 16, 32, 64)
"""Pixels between neighbouring cells of P2..P6."""


@dataclass(frozen=True, eq=False)
class FeaturePyramid:
    """Features of B images of one view.

    Args:
        levels: P2..P6 with strides 4, 8, 16, 32, 64, each of shape (B, C, H / stride, W / stride).
        height: The height of the images, pixels.
        width: The width of the images, pixels.
    """

    levels: tuple[Tensor, ...]
    height: int
    width: int

    def halves(self) -> tuple[FeaturePyramid, FeaturePyramid]:
        """The pyramids of the first and the second half of the images."""
        first, second = zip(*(level.chunk(2) for level in self.levels), strict=True)
        return (
            FeaturePyramid(first, self.height, self.width),
            FeaturePyramid(second, self.height, self.width),
        )


class FeaturePyramidNetwork(nn.Module):
    """C2..C5 to P2..P6: 1x1 laterals, added from the top down, a 3x3 convolution on each sum.

    Args:
        inputs: Channels of C2..C5.
        channels: The number of channels of every level that comes out.
    """

    def __init__(self, inputs: Sequence[int], channels: int) -> None:
        super().__init__()
        self.lateral = nn.ModuleList(nn.Conv2d(each, channels, 1) for each in inputs)
        self.smooth = nn.ModuleList(nn.Conv2d(channels, channels, 3, padding=1) for _ in inputs)

    def forward(self, levels: Sequence[Tensor]) -> tuple[Tensor, ...]:
        """P6 is every second cell of P5."""
        laterals = [layer(level) for layer, level in zip(self.lateral, levels, strict=True)]
        sums = [laterals[-1]]
        for lateral in reversed(laterals[:-1]):
            size = lateral.shape[-2:]
            sums.append(lateral + functional.interpolate(sums[-1], size=size, mode="nearest"))
        smooth = [layer(level) for layer, level in zip(self.smooth, reversed(sums), strict=True)]
        return (*smooth, functional.max_pool2d(smooth[-1], 1, stride=2))
