"""The body of residual networks (He et al., CVPR 2016) that detectors look through."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal, Protocol

from torch import Tensor, nn
from torch.nn import functional

from avsec_gym.errors import ConfigurationError

Normalisation = Literal["frozen_batch", "batch", "group"]
"""Batch statistics that never change, that are learned, or groups of channels."""
Edges = Literal["zeros", "replicate"]
"""What convolutions see beyond the edge of their inputs: nothing, or the nearest value."""

EXPANSION = 4
"""A bottleneck's outer channels over its inner ones."""

GROUPS = 8
"""Groups of channels, where groups are normalised."""


class ResidualConfiguration(Protocol):
    """The numbers of a body, as part of a detector's configuration."""

    @property
    def stem_channels(self) -> int:
        """Channels after the first convolution."""
        ...

    @property
    def stage_blocks(self) -> tuple[int, int, int, int]:
        """Bottlenecks of the four stages."""
        ...

    @property
    def stage_channels(self) -> tuple[int, int, int, int]:
        """Inner channels of their bottlenecks; `EXPANSION` times as many come out."""
        ...

    @property
    def normalisation(self) -> Normalisation:
        """The normalisation behind each convolution."""
        ...

    @property
    def edges(self) -> Edges:
        """The kind of values beyond the inputs of convolutions larger than 1x1."""
        ...

    @property
    def he_initialisation(self) -> bool:
        """Whether blocks begin as identities, for training from scratch."""
        ...


class Bottleneck(nn.Module):
    """1x1, 3x3, 1x1 beside an identity; the first 1x1 has the stride, as in Caffe's ResNet."""

    def __init__(
        self, inputs: int, channels: int, stride: int, configuration: ResidualConfiguration
    ) -> None:
        super().__init__()
        outputs = EXPANSION * channels
        normalisation, edges = configuration.normalisation, configuration.edges
        self.conv1 = nn.Conv2d(inputs, channels, 1, stride=stride, bias=False)
        self.bn1 = normalisation_layer(channels, normalisation)
        self.conv2 = nn.Conv2d(channels, channels, 3, padding=1, bias=False, padding_mode=edges)
        self.bn2 = normalisation_layer(channels, normalisation)
        self.conv3 = nn.Conv2d(channels, outputs, 1, bias=False)
        self.bn3 = normalisation_layer(outputs, normalisation)
        self.downsample: nn.Sequential | None = None
        if stride != 1 or inputs != outputs:
            self.downsample = nn.Sequential(
                nn.Conv2d(inputs, outputs, 1, stride=stride, bias=False),
                normalisation_layer(outputs, normalisation),
            )

    def forward(self, inputs: Tensor) -> Tensor:
        """(B, C, H, W) to (B, 4 * channels, H / stride, W / stride)."""
        hidden = functional.relu(self.bn1(self.conv1(inputs)))
        hidden = functional.relu(self.bn2(self.conv2(hidden)))
        beside = inputs if self.downsample is None else self.downsample(inputs)
        return functional.relu(self.bn3(self.conv3(hidden)) + beside)


def stem(configuration: ResidualConfiguration) -> nn.Sequential:
    """7x7 convolution and pooling, to a quarter of the resolution (halves are rounded up)."""
    channels = configuration.stem_channels
    convolution = nn.Conv2d(
        3, channels, 7, stride=2, padding=3, bias=False, padding_mode=configuration.edges
    )
    initialise_convolution(convolution)
    return nn.Sequential(
        convolution,
        normalisation_layer(channels, configuration.normalisation),
        nn.ReLU(inplace=True),
        nn.MaxPool2d(3, stride=2, padding=0, ceil_mode=True),
    )


def residual_stages(configuration: ResidualConfiguration) -> list[nn.Sequential]:
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


def freeze(module: nn.Module) -> None:
    """Keep parameters and statistics as they are; gradients still pass through to the pixels."""
    module.eval()
    module.requires_grad_(False)


def freeze_body(
    network: nn.Module, body: Sequence[nn.Module], stages: int, normalisation: Normalisation
) -> None:
    """Freeze the first stages of a network's body, and all batch statistics where these are.

    Args:
        network: The whole network.
        body: The stages of its body, the one next to the image first.
        stages: How many of them are frozen.
        normalisation: The normalisation of the network; ``frozen_batch`` freezes the statistics
            wherever they are.
    """
    for stage in body[:stages]:
        freeze(stage)
    if normalisation == "frozen_batch":
        for module in network.modules():
            if isinstance(module, nn.BatchNorm2d):
                freeze(module)


def normalisation_layer(
    channels: int, normalisation: Normalisation
) -> nn.BatchNorm2d | nn.GroupNorm:
    """The layer that normalises channels.

    Raises:
        ConfigurationError: Channels that do not form whole groups.
    """
    if normalisation != "group":
        return nn.BatchNorm2d(channels)
    if channels % GROUPS:
        raise ConfigurationError(
            f"{GROUPS} groups need a multiple of {GROUPS} channels to normalise, got {channels}"
        )
    return nn.GroupNorm(GROUPS, channels)
