"""PointRCNN's first stage: for every point, whether it is on an object, and where that one is.

With `proposals` it can be used by itself, as the thesis does for connected vehicles (chapter 4).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from torch import Tensor, nn

from avsec_gym.perception.detectors.pointrcnn.backbone import PointBackbone
from avsec_gym.perception.detectors.pointrcnn.configuration import PointRcnnConfiguration
from avsec_gym.perception.nn.point_layers import PointLayer

_PRIOR = 0.01
"""Probability of an object at any point that an untrained network reports."""
_BOX_DEVIATION = 1e-3


@dataclass(frozen=True, eq=False)
class PointOutput:
    """The output for each point of B scans.

    Args:
        points: Camera frame, shape (B, N, 3).
        features: The features, shape (B, N, channels).
        logits: The logits that it is on an object, shape (B, N).
        codes: Where the middle of that object is, how large and how turned; see `BinCoding`,
            shape (B, N, channels).
    """

    points: Tensor
    features: Tensor
    logits: Tensor
    codes: Tensor

    @property
    def scores(self) -> Tensor:
        """Probabilities, shape (B, N)."""
        return torch.sigmoid(self.logits.float())


class ProposalNetwork(nn.Module):
    """Backbone and two heads."""

    def __init__(self, configuration: PointRcnnConfiguration) -> None:
        super().__init__()
        self.backbone_net = PointBackbone(configuration.levels, configuration.propagation)
        features, dropout = configuration.propagation[0][-1], configuration.dropout
        self.rpn_cls_layer = point_head(features, configuration.head, 1, dropout=dropout)
        self.rpn_reg_layer = point_head(
            features, configuration.head, configuration.coding.channels, dropout=dropout
        )
        last = self.rpn_cls_layer[-1]
        nn.init.constant_(last.get_parameter("conv.bias"), -math.log((1 - _PRIOR) / _PRIOR))
        nn.init.normal_(self.rpn_reg_layer[-1].get_parameter("conv.weight"), 0, _BOX_DEVIATION)

    def forward(self, points: Tensor) -> PointOutput:
        """Points in the camera frame, shape (B, N, 3)."""
        features = self.backbone_net(points)
        logits = self.rpn_cls_layer(features)[..., 0]
        return PointOutput(points, features, logits, self.rpn_reg_layer(features))


def point_head(
    inputs: int,
    hidden: tuple[int, ...],
    outputs: int,
    *,
    dropout: float,
    is_normalised: bool = True,
) -> nn.Sequential:
    """Layers from features to the outputs, with a dropout behind the first."""
    layers: list[nn.Module] = []
    for channels in hidden:
        layers.append(PointLayer(inputs, channels, dimensions=1, is_normalised=is_normalised))
        inputs = channels
    layers.append(PointLayer(inputs, outputs, dimensions=1, is_normalised=False, has_relu=False))
    layers.insert(1, nn.Dropout(dropout))
    return nn.Sequential(*layers)
