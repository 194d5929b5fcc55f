"""Convolution and normalisation as one layer, in two and three dimensions, up and down.

The layers are plain `nn.Sequential` objects, since the ``state_dict`` keys of PSMNet and DSGN
count on it: ``0`` is the convolution of a pair, ``1`` its normalisation.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Literal

import torch
from torch import Tensor, nn
from torch.nn import functional

Dimensions = Literal[2, 3]


_SMALL_VOLUME = 20480
"""Channels x depth x height of a single volume up to which torch does not ask oneDNN
(``use_mkldnn`` in ATen's Convolution.cpp)."""


class VolumeConvolution(nn.Conv3d):
    """`nn.Conv3d` (cubic kernel, zero padding, no dilation), fast for a single volume on a CPU.

    There torch 2 keeps small volumes away from oneDNN and takes five times as long as it does for
    two of them; the same sum, as convolutions in 2D over neighbouring slices, is quick.
    """

    def forward(self, volume: Tensor) -> Tensor:
        """(B, C, D, H, W) to (B, out, D', H', W')."""
        if self._is_quick(volume):
            return super().forward(volume)
        if self.kernel_size[0] == self.stride[0] == 1:
            return self._of_points(volume)
        kernel, stride, margin = self.kernel_size[0], self.stride[0], int(self.padding[0])
        slices = functional.pad(volume[0].transpose(0, 1), (0, 0, 0, 0, 0, 0, margin, margin))
        count = (len(slices) - kernel) // stride + 1
        neighbours = [slices[i : i + stride * (count - 1) + 1 : stride] for i in range(kernel)]
        result = functional.conv2d(
            torch.cat(neighbours, 1).contiguous(memory_format=torch.channels_last),
            self.weight.transpose(1, 2).flatten(1, 2),
            self.bias,
            stride,
            margin,
        )
        return result.transpose(0, 1)[None]

    def _of_points(self, volume: Tensor) -> Tensor:
        """A kernel of one: a product of matrices, where a convolution would reorder the volume."""
        mixed = self.weight.flatten(1) @ volume[0].flatten(1)
        if self.bias is not None:
            mixed = mixed + self.bias[:, None]
        return mixed.view(1, -1, *volume.shape[2:])

    def _is_quick(self, volume: Tensor) -> bool:
        """Whether torch has a quick convolution for this, in 3D."""
        if volume.device.type != "cpu" or len(volume) > 1:
            return True
        if self.kernel_size[0] == 1:
            return False
        return volume.dtype == torch.float32 and volume[0, ..., 0].numel() > _SMALL_VOLUME


class DoublingVolumeConvolution(nn.ConvTranspose3d):
    """`nn.ConvTranspose3d` that doubles the size, fast for a single volume on a CPU.

    There torch has no other than its own plain one, which takes four times as long as the same sum
    as transposed convolutions in 2D: a slice of the result has one or two slices before it.

    Args:
        channels: What comes in.
        out: Channels that leave.
    """

    def __init__(self, channels: int, out: int) -> None:
        super().__init__(channels, out, 3, stride=2, padding=1, output_padding=1, bias=False)

    def forward(self, volume: Tensor, output_size: list[int] | None = None) -> Tensor:
        """(B, C, D, H, W) to (B, out, 2 D, 2 H, 2 W)."""
        if volume.device.type != "cpu" or len(volume) > 1 or output_size is not None:
            return super().forward(volume, output_size)
        slices = volume[0].transpose(0, 1)
        next_ones = functional.pad(slices[1:], (0, 0, 0, 0, 0, 0, 0, 1))
        before, middle, behind = self.weight.unbind(2)
        even = functional.conv_transpose2d(slices, middle, None, 2, 1, 1)
        odd = functional.conv_transpose2d(
            torch.cat([slices, next_ones], 1), torch.cat([behind, before]), None, 2, 1, 1
        )
        return torch.stack([even, odd], 1).flatten(0, 1).transpose(0, 1)[None]


_CONVOLUTION = {2: nn.Conv2d, 3: VolumeConvolution}
_BATCH_NORMALISATION = {2: nn.BatchNorm2d, 3: nn.BatchNorm3d}


def convolution(
    channels: int,
    out: int,
    *,
    groups: int,
    dimensions: Dimensions = 2,
    kernel: int = 3,
    stride: int = 1,
    dilation: int = 1,
) -> nn.Sequential:
    """Convolution without bias that keeps the size (or divides it by the stride), normalised.

    Args:
        channels: What comes in.
        out: Channels that leave.
        groups: The number of groups of channels, see `normalisation`.
        dimensions: The number of dimensions of space: images or volumes.
        kernel: The kernel's odd size in every dimension.
        stride: The stride in every dimension.
        dilation: The dilation in every dimension.
    """
    return nn.Sequential(
        _CONVOLUTION[dimensions](
            channels,
            out,
            kernel,
            stride=stride,
            padding=dilation * (kernel // 2),
            dilation=dilation,
            bias=False,
        ),
        normalisation(out, groups, dimensions),
    )


def convolutions(
    *channels: int,
    groups: int,
    dimensions: Dimensions = 2,
    kernel: int = 3,
    stride: int = 1,
    dilation: int = 1,
) -> nn.Sequential:
    """A row of `convolution` from each number of channels to the next, a ReLU behind each.

    The stride is that of the first.
    """
    layers: list[nn.Module] = []
    for start, out in pairwise(channels):
        step = 1 if layers else stride
        layers += [
            convolution(
                start,
                out,
                groups=groups,
                dimensions=dimensions,
                kernel=kernel,
                stride=step,
                dilation=dilation,
            ),
            nn.ReLU(inplace=True),
        ]
    return nn.Sequential(*layers)


def doubling_convolution(
    channels: int, out: int, *, groups: int, dimensions: Dimensions
) -> nn.Sequential:
    """Transposed convolution that doubles the size, normalised."""
    doubling = (
        DoublingVolumeConvolution(channels, out)
        if dimensions == 3
        else nn.ConvTranspose2d(channels, out, 3, stride=2, padding=1, output_padding=1, bias=False)
    )
    return nn.Sequential(doubling, normalisation(out, groups, dimensions))


def normalisation(channels: int, groups: int, dimensions: Dimensions) -> nn.Module:
    """Normalisation over groups of channels (Wu & He, 2018); over the batch where they are fewer.

    Args:
        channels: The number of channels of the tensor to be normalised.
        groups: The number of groups of channels; 0 normalises over the batch, whatever the
            channels.
        dimensions: The number of dimensions of space.
    """
    if groups and channels >= groups:
        return nn.GroupNorm(groups, channels)
    return _BATCH_NORMALISATION[dimensions](channels)


def initialise(network: nn.Module) -> None:
    """Draw every convolution's weights after He et al. (2015), for the paths that go backwards."""
    for layer in network.modules():
        if isinstance(layer, nn.Conv2d | nn.Conv3d):
            nn.init.kaiming_normal_(layer.weight, mode="fan_out", nonlinearity="relu")
            if layer.bias is not None:
                nn.init.zeros_(layer.bias)
