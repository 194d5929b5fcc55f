"""YOLOv3 (Redmon and Farhadi, 2018): Darknet-53, and a set of layers for each of three scales."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import torch
from torch import Tensor, nn
from torch.nn import functional

from avsec_gym.perception.detectors.yolo.configuration import STRIDES, YoloConfiguration
from avsec_gym.perception.nn.anchors import per_anchor
from avsec_gym.perception.nn.resnet import normalisation_layer

_LEAK = 0.1
_OBJECTNESS = 4
"""Its place among the numbers of a box."""


@dataclass(frozen=True, eq=False)
class YoloOutput:
    """Outputs for B images with P boxes each: finest scale first, row by row, prior by prior.

    Args:
        logits: t_x, t_y, t_w, t_h, of objectness, of each of K classes, shape (B, P, 5 + K).
        cells: Column and row of each box's cell, shape (P, 2).
        strides: The pixels between neighbouring cells, shape (P, 1).
        priors: Width and height, pixels, shape (P, 2).
    """

    logits: Tensor
    cells: Tensor
    strides: Tensor
    priors: Tensor

    @property
    def objectness(self) -> Tensor:
        """Logits, shape (B, P)."""
        return self.logits[..., _OBJECTNESS]

    @property
    def classes(self) -> Tensor:
        """Logits, shape (B, P, K)."""
        return self.logits[..., _OBJECTNESS + 1 :]


class YoloNetwork(nn.Module):
    """A network from normalised images to the outputs for every box.

    Args:
        configuration: The numbers.
    """

    def __init__(self, configuration: YoloConfiguration) -> None:
        super().__init__()
        self.configuration = configuration
        first, *deeper = _channels(configuration)
        self.stem = _convolution(3, first, 3, configuration)
        self.stages = nn.ModuleList(
            _stage(inputs, outputs, blocks, configuration)
            for (inputs, outputs), blocks in zip(
                pairwise([first, *deeper]), configuration.stage_blocks, strict=True
            )
        )
        self.sets, self.outputs, self.routes = nn.ModuleList(), nn.ModuleList(), nn.ModuleList()
        above = 0
        for channels in reversed(configuration.stage_channels[-len(STRIDES) :]):
            half = channels // 2
            if above:
                self.routes.append(_convolution(above, half, 1, configuration))
                above = half
            self.sets.append(_set(channels + above, half, configuration))
            self.outputs.append(
                nn.Sequential(
                    _convolution(half, channels, 3, configuration),
                    nn.Conv2d(channels, configuration.each * configuration.numbers, 1),
                )
            )
            above = half
        _initialise(self)

    def forward(self, images: Tensor) -> YoloOutput:
        """Everything about B images (B, 3, H, W), H and W multiples of 32."""
        # Channels last, which small convolutions are faster with.
        features, levels = self.stem(images.contiguous(memory_format=torch.channels_last)), []
        for stage in self.stages:
            features = stage(features)
            levels.append(features)
        maps: list[Tensor] = []
        for number, level in enumerate(reversed(levels[-len(STRIDES) :])):
            if number:
                route = self.routes[number - 1](features)
                level = torch.cat((functional.interpolate(route, scale_factor=2.0), level), 1)
            features = self.sets[number](level)
            maps.append(self.outputs[number](features))
        maps.reverse()
        logits = torch.cat([per_anchor(each, self.configuration.numbers) for each in maps], 1)
        # In the weights' precision, whatever a mixed one computes with: boxes need it.
        like = next(self.parameters())
        shapes = [(each.shape[2], each.shape[3]) for each in maps]
        grid = (values.to(like) for values in box_grid(shapes, self.configuration))
        return YoloOutput(logits.to(like), *grid)


def box_grid(
    shapes: Sequence[tuple[int, int]], configuration: YoloConfiguration
) -> tuple[Tensor, Tensor, Tensor]:
    """Cells (P, 2), strides (P, 1) and priors (P, 2) of `YoloOutput`, for maps of such shapes."""
    each = configuration.each
    cells, strides, priors = [], [], []
    for number, ((rows, columns), stride) in enumerate(zip(shapes, STRIDES, strict=True)):
        v, u = torch.meshgrid(torch.arange(rows), torch.arange(columns), indexing="ij")
        cells.append(torch.stack((u, v), -1).reshape(-1, 2).repeat_interleave(each, 0))
        strides.append(torch.full((rows * columns * each, 1), stride))
        own = torch.tensor(configuration.priors[number * each : (number + 1) * each])
        priors.append(own.repeat(rows * columns, 1))
    return torch.cat(cells), torch.cat(strides), torch.cat(priors)


class ResidualBlock(nn.Module):
    """1x1 to half of the channels and 3x3 back, beside an identity."""

    def __init__(self, channels: int, configuration: YoloConfiguration) -> None:
        super().__init__()
        self.first = _convolution(channels, channels // 2, 1, configuration)
        self.second = _convolution(channels // 2, channels, 3, configuration)

    def forward(self, inputs: Tensor) -> Tensor:
        """(B, C, H, W) to the same shape."""
        return inputs + self.second(self.first(inputs))


def _channels(configuration: YoloConfiguration) -> list[int]:
    return [configuration.stem_channels, *configuration.stage_channels]


def _stage(
    inputs: int, outputs: int, blocks: int, configuration: YoloConfiguration
) -> nn.Sequential:
    halving = _convolution(inputs, outputs, 3, configuration, stride=2)
    return nn.Sequential(halving, *(ResidualBlock(outputs, configuration) for _ in range(blocks)))


def _set(inputs: int, half: int, configuration: YoloConfiguration) -> nn.Sequential:
    """Five convolutions, 1x1 and 3x3 in turn."""
    channels = [inputs, half, 2 * half, half, 2 * half, half]
    return nn.Sequential(
        *(
            _convolution(one, two, 3 if two > half else 1, configuration)
            for one, two in pairwise(channels)
        )
    )


def _convolution(
    inputs: int, outputs: int, kernel: int, configuration: YoloConfiguration, stride: int = 1
) -> nn.Sequential:
    return nn.Sequential(
        nn.Conv2d(
            inputs,
            outputs,
            kernel,
            stride=stride,
            padding=kernel // 2,
            bias=False,
            padding_mode=configuration.edges,
        ),
        normalisation_layer(outputs, configuration.normalisation),
        nn.LeakyReLU(_LEAK, inplace=True),
    )


def _initialise(network: YoloNetwork) -> None:
    """After He et al. (2015); the outputs near zero, objects unlikely."""
    for module in network.modules():
        if isinstance(module, nn.Conv2d):
            nn.init.kaiming_normal_(module.weight, _LEAK, nonlinearity="leaky_relu")
    prior = network.configuration.prior_objectness
    for output in network.outputs:
        *_, last = (layer for layer in output.modules() if isinstance(layer, nn.Conv2d))
        assert last.bias is not None
        nn.init.normal_(last.weight, 0, 0.01)
        nn.init.zeros_(last.bias)
        with torch.no_grad():
            last.bias[_OBJECTNESS :: network.configuration.numbers] = math.log(prior / (1 - prior))
