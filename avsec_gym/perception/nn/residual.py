"""Residual blocks of PSMNet and DSGN: unlike those of ResNet, without ReLU after the sum."""

from __future__ import annotations

from torch import Tensor, nn

from avsec_gym.perception.nn.convolution import convolution, convolutions


class BasicBlock(nn.Module):
    """Two 3x3 convolutions, added to what came in (through a 1x1 one where the shape changes)."""

    def __init__(
        self, channels: int, out: int, *, groups: int, stride: int = 1, dilation: int = 1
    ) -> None:
        super().__init__()
        self.conv1 = convolutions(channels, out, groups=groups, stride=stride, dilation=dilation)
        self.conv2 = convolution(out, out, groups=groups, dilation=dilation)
        self.downsample = (
            convolution(channels, out, groups=groups, kernel=1, stride=stride)
            if stride != 1 or channels != out
            else None
        )

    def forward(self, features: Tensor) -> Tensor:
        """(B, channels, H, W) to (B, out, H/stride, W/stride)."""
        skipped = features if self.downsample is None else self.downsample(features)
        return skipped + self.conv2(self.conv1(features))


def residual_stage(
    channels: int, out: int, blocks: int, *, groups: int, stride: int = 1, dilation: int = 1
) -> nn.Sequential:
    """Blocks in a row, the first of which changes channels and size."""
    first = BasicBlock(channels, out, groups=groups, stride=stride, dilation=dilation)
    rest = (BasicBlock(out, out, groups=groups, dilation=dilation) for _ in range(blocks - 1))
    return nn.Sequential(first, *rest)
