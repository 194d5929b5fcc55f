"""The residual network and feature pyramid that both views go through."""

from __future__ import annotations

import math
from dataclasses import dataclass

from torch import Tensor, nn
from torch.nn import functional

from avsec_gym.errors import ConfigurationError
from avsec_gym.perception.detectors.stereo_rcnn.configuration import (
    Normalisation,
    StereoRcnnConfiguration,
)

EXPANSION = 4
"""A bottleneck's outer channels over its inner ones."""

GROUPS = 8
"""Of channels, where groups are normalised."""


@dataclass(frozen=True, eq=False)
class FeaturePyramid:
    """Features of B images of one view.

    Args:
        levels: P2..P6 with strides 4, 8, 16, 32, 64, each of shape (B, C, H / stride, W / stride).
        height: Of the images, pixels.
        width: Of the images, pixels.
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


class Bottleneck(nn.Module):
    """1x1, 3x3, 1x1 beside an identity; the first 1x1 has the stride, as in Caffe's ResNet."""

    def __init__(
        self, inputs: int, channels: int, stride: int, configuration: StereoRcnnConfiguration
    ) -> None:
        super().__init__()
        outputs = EXPANSION * channels
        normalisation, edges = configuration.normalisation, configuration.edges
        self.conv1 = nn.Conv2d(inputs, channels, 1, stride=stride, bias=False)
        self.bn1 = _norm(channels, normalisation)
        self.conv2 = nn.Conv2d(channels, channels, 3, padding=1, bias=False, padding_mode=edges)
        self.bn2 = _norm(channels, normalisation)
        self.conv3 = nn.Conv2d(channels, outputs, 1, bias=False)
        self.bn3 = _norm(outputs, normalisation)
        self.downsample: nn.Sequential | None = None
        if stride != 1 or inputs != outputs:
            self.downsample = nn.Sequential(
                nn.Conv2d(inputs, outputs, 1, stride=stride, bias=False),
                _norm(outputs, normalisation),
            )

    def forward(self, inputs: Tensor) -> Tensor:
        """(B, C, H, W) to (B, 4 * channels, H / stride, W / stride)."""
        hidden = functional.relu(self.bn1(self.conv1(inputs)))
        hidden = functional.relu(self.bn2(self.conv2(hidden)))
        beside = inputs if self.downsample is None else self.downsample(inputs)
        return functional.relu(self.bn3(self.conv3(hidden)) + beside)


def stem(configuration: StereoRcnnConfiguration) -> nn.Sequential:
    """7x7 convolution and pooling, to a quarter of the resolution (halves are rounded up)."""
    channels = configuration.stem_channels
    convolution = nn.Conv2d(
        3, channels, 7, stride=2, padding=3, bias=False, padding_mode=configuration.edges
    )
    initialise_convolution(convolution)
    return nn.Sequential(
        convolution,
        _norm(channels, configuration.normalisation),
        nn.ReLU(inplace=True),
        nn.MaxPool2d(3, stride=2, padding=0, ceil_mode=True),
    )


def residual_stages(configuration: StereoRcnnConfiguration) -> list[nn.Sequential]:
    """The four stages C2..C5 with strides 4, 8, 16, 32."""
    stages = []
    inputs = configuration.stem_channels
    for number, (blocks, channels) in enumerate(
        zip(configuration.stage_blocks, configuration.stage_channels, strict=True)
    ):
        bottlenecks = []
        for block in range(blocks):
            stride = 2 if number > 0 and block == 0 else 1
            bottlenecks.append(Bottleneck(inputs, channels, stride, configuration))
            inputs = EXPANSION * channels
        # The checkpoints have each stage within a sequence of its own.
        stages.append(nn.Sequential(nn.Sequential(*bottlenecks)))
    for stage in stages:
        for module in stage.modules():
            if isinstance(module, nn.Conv2d):
                initialise_convolution(module)
            if isinstance(module, Bottleneck) and configuration.he_initialisation:
                nn.init.zeros_(module.bn3.weight)
    return stages


def initialise_convolution(layer: nn.Conv2d) -> None:
    """Normal weights, by the number of outputs that an input reaches (He et al., 2015)."""
    reached = layer.out_channels * math.prod(layer.kernel_size)
    nn.init.normal_(layer.weight, 0, math.sqrt(2 / reached))


def merge(upper: Tensor, lateral: Tensor) -> Tensor:
    """A coarser level, enlarged to the size of a finer one, and added to it."""
    size = lateral.shape[-2:]
    return functional.interpolate(upper, size=size, mode="bilinear", align_corners=False) + lateral


def freeze(module: nn.Module) -> None:
    """Keep parameters and statistics as they are; gradients still pass through to the pixels."""
    module.eval()
    module.requires_grad_(False)


def _norm(channels: int, normalisation: Normalisation) -> nn.BatchNorm2d | nn.GroupNorm:
    if normalisation != "group":
        return nn.BatchNorm2d(channels)
    if channels % GROUPS:
        raise ConfigurationError(
            f"{GROUPS} groups need a multiple of {GROUPS} channels to normalise, got {channels}"
        )
    return nn.GroupNorm(GROUPS, channels)
