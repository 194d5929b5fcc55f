"""The hourglass of PSMNet and DSGN: down to a quarter of the size and back, in 2D or 3D."""

from __future__ import annotations

from torch import Tensor, nn
from torch.nn import functional

from avsec_gym.perception.nn.convolution import (
    Dimensions,
    convolution,
    convolutions,
    doubling_convolution,
)


class Hourglass(nn.Module):
    """Chang & Chen (2018), table 1; the sizes of its input are multiples of 4."""

    def __init__(self, channels: int, *, groups: int, dimensions: Dimensions) -> None:
        super().__init__()
        wide = 2 * channels

        self.conv1 = convolutions(channels, wide, groups=groups, dimensions=dimensions, stride=2)
        self.conv2 = convolution(wide, wide, groups=groups, dimensions=dimensions)
        self.conv3 = convolutions(wide, wide, groups=groups, dimensions=dimensions, stride=2)
        self.conv4 = convolutions(wide, wide, groups=groups, dimensions=dimensions)
        self.conv5 = doubling_convolution(wide, wide, groups=groups, dimensions=dimensions)
        self.conv6 = doubling_convolution(wide, channels, groups=groups, dimensions=dimensions)

    def forward(
        self, volume: Tensor, down: Tensor | None = None, up: Tensor | None = None
    ) -> tuple[Tensor, Tensor, Tensor]:
        """A volume seen at a coarser scale; the caller adds the residual.

        Args:
            volume: The volume, shape (B, channels, ...).
            down: Features of an earlier hourglass on its way down, at half the size.
            up: The same on its way up.

        Returns:
            The result, of the volume's shape, and this hourglass' own `down` and `up`,
            shape (B, 2 channels, ...) at half the size.
        """
        halved = self.conv2(self.conv1(volume))
        going_down = functional.relu(halved if up is None else halved + up)
        risen = self.conv5(self.conv4(self.conv3(going_down)))
        going_up = functional.relu(risen + (going_down if down is None else down))
        return self.conv6(going_up), going_down, going_up
