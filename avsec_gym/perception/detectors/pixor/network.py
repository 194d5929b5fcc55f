"""PIXOR's network: a residual backbone, two steps back up, and a header for every cell.

Yang, Luo, Urtasun: PIXOR, CVPR 2018, as the public code of that name has it, with its
``state_dict`` keys: github.com/philip-huang/PIXOR; the authors published none.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from torch import Tensor, nn
from torch.nn import functional

from avsec_gym.perception.detectors.pixor.configuration import PixorConfiguration

EXPANSION = 4
"""A bottleneck's outer channels over its inner ones."""
_PRIOR = 0.01
"""Probability of an object in any cell that an untrained network reports."""


@dataclass(frozen=True, eq=False)
class PixorOutput:
    """The output for each cell of B scans.

    Args:
        logits: The logits of an object, shape (B, rows, columns).
        values: Where it is, how large and how turned, normalised, shape (B, 6, rows, columns).
        in_view: Cells in the field of view, shape (rows, columns).
    """

    logits: Tensor
    values: Tensor
    in_view: Tensor

    @property
    def scores(self) -> Tensor:
        """Probabilities, 0 outside of the field of view, shape (B, rows, columns)."""
        return torch.sigmoid(self.logits) * self.in_view


class PixorNetwork(nn.Module):
    """The whole network.

    Unlike in the public code, which writes it into the weights of the last layer, the prior of
    classification stands in the bias.
    """

    def __init__(self, configuration: PixorConfiguration) -> None:
        super().__init__()
        self.backbone = _Backbone(configuration)
        self.header = _Header(configuration.laterals[-1], configuration.header_relu)
        for layer in self.modules():
            if isinstance(layer, nn.Conv2d):
                nn.init.kaiming_normal_(layer.weight, mode="fan_out", nonlinearity="relu")
        for head in (self.header.clshead, self.header.reghead):
            for values in head.parameters():
                nn.init.zeros_(values)
        nn.init.constant_(
            self.header.get_parameter("clshead.bias"), -math.log((1 - _PRIOR) / _PRIOR)
        )
        self.register_buffer("in_view", _in_view(configuration), persistent=False)

    def forward(self, scans: Tensor) -> PixorOutput:
        """Scans as `bird_eye_input` gives them, shape (B, channels, rows, columns)."""
        logits, values = self.header(self.backbone(scans))
        return PixorOutput(logits[:, 0], values, self.get_buffer("in_view"))


class _Backbone(nn.Module):
    def __init__(self, configuration: PixorConfiguration) -> None:
        super().__init__()
        stem = configuration.stem
        self.conv1 = _convolution(configuration.region.shape[0], stem)
        self.bn1 = nn.BatchNorm2d(stem)
        self.conv2 = _convolution(stem, stem)
        self.bn2 = nn.BatchNorm2d(stem)
        channels = [stem, *(EXPANSION * planes for planes in configuration.planes)]
        self.block2, self.block3, self.block4, self.block5 = (
            _stage(inputs, planes, blocks, stride)
            for inputs, planes, blocks, stride in zip(
                channels[:-1],
                configuration.planes,
                configuration.blocks,
                configuration.strides,
                strict=True,
            )
        )
        coarse, middle, fine = configuration.laterals
        self.latlayer1 = nn.Conv2d(channels[4], coarse, 1)
        self.latlayer2 = nn.Conv2d(channels[3], middle, 1)
        self.latlayer3 = nn.Conv2d(channels[2], fine, 1)
        _, _, stride, last_stride = configuration.strides
        self.deconv1 = nn.ConvTranspose2d(coarse, middle, 3, stride=last_stride, padding=1)
        self.deconv2 = nn.ConvTranspose2d(middle, fine, 3, stride=stride, padding=1)

    def forward(self, scans: Tensor) -> Tensor:
        """(B, channels, rows, columns) to (B, fine, rows / stride, columns / stride)."""
        stem = functional.relu(self.bn1(self.conv1(scans)))
        stem = functional.relu(self.bn2(self.conv2(stem)))
        third = self.block3(self.block2(stem))
        fourth = self.block4(third)
        coarse = self.latlayer1(self.block5(fourth))
        lateral = self.latlayer2(fourth)
        middle = lateral + self.deconv1(coarse, output_size=lateral.shape[-2:])
        lateral = self.latlayer3(third)
        fine: Tensor = lateral + self.deconv2(middle, output_size=lateral.shape[-2:])
        return fine


class _Header(nn.Module):
    def __init__(self, channels: int, has_relu: bool) -> None:
        super().__init__()
        for number in range(1, 5):
            self.add_module(f"conv{number}", _convolution(channels, channels))
            self.add_module(f"bn{number}", nn.BatchNorm2d(channels))
        self.clshead = nn.Conv2d(channels, 1, 3, padding=1)
        self.reghead = nn.Conv2d(channels, 6, 3, padding=1)
        self._has_relu = has_relu

    def forward(self, features: Tensor) -> tuple[Tensor, Tensor]:
        """Logits (B, 1, ...) and values (B, 6, ...)."""
        for number in range(1, 5):
            convolution = self.get_submodule(f"conv{number}")
            features = self.get_submodule(f"bn{number}")(convolution(features))
            if self._has_relu:
                features = functional.relu(features)
        return self.clshead(features), self.reghead(features)


class _Bottleneck(nn.Module):
    """1x1, 3x3, 1x1 beside an identity; the 3x3 has the stride."""

    def __init__(self, inputs: int, planes: int, stride: int, is_first: bool) -> None:
        super().__init__()
        outputs = EXPANSION * planes
        self.conv1 = nn.Conv2d(inputs, planes, 1, bias=False)
        self.bn1 = nn.BatchNorm2d(planes)
        self.conv2 = _convolution(planes, planes, stride)
        self.bn2 = nn.BatchNorm2d(planes)
        self.conv3 = nn.Conv2d(planes, outputs, 1, bias=False)
        self.bn3 = nn.BatchNorm2d(outputs)
        self.downsample: nn.Module = nn.Identity()
        if is_first:
            self.downsample = nn.Sequential(
                nn.Conv2d(inputs, outputs, 1, stride=stride, bias=False), nn.BatchNorm2d(outputs)
            )

    def forward(self, features: Tensor) -> Tensor:
        hidden = functional.relu(self.bn1(self.conv1(features)))
        hidden = functional.relu(self.bn2(self.conv2(hidden)))
        return functional.relu(self.downsample(features) + self.bn3(self.conv3(hidden)))


def _stage(inputs: int, planes: int, blocks: int, stride: int) -> nn.Sequential:
    first = _Bottleneck(inputs, planes, stride, is_first=True)
    rest = (_Bottleneck(EXPANSION * planes, planes, 1, is_first=False) for _ in range(blocks - 1))
    return nn.Sequential(first, *rest)


def _convolution(inputs: int, outputs: int, stride: int = 1) -> nn.Conv2d:
    return nn.Conv2d(inputs, outputs, 3, stride=stride, padding=1, bias=False)


def _in_view(configuration: PixorConfiguration) -> Tensor:
    """Cells whose corner is in the field of view, shape (rows, columns)."""
    x, y = torch.from_numpy(configuration.corners()).unbind(-1)
    return torch.atan2(y, x).abs() < math.radians(configuration.field_of_view / 2)
