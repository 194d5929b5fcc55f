"""PointRCNN's second stage: the points in each proposal, seen from it, correct it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor, nn

from avsec_gym.perception.detectors.pointrcnn.backbone import set_abstraction
from avsec_gym.perception.detectors.pointrcnn.configuration import PointRcnnConfiguration
from avsec_gym.perception.detectors.pointrcnn.proposal_network import PointOutput, point_head
from avsec_gym.perception.nn.point_layers import PointLayers
from avsec_gym.perception.nn.points_in_boxes import (
    enlarged,
    first_inside,
    in_box_frames,
    points_in_boxes,
)

_BOX_DEVIATION = 1e-3
_DISTANCE_SCALE = 70.0
"""Metres that are one of the network's unit of distance."""
_EXTRAS = 5
"""Three coordinates, whether a point is on an object, and its distance."""


@dataclass(frozen=True, eq=False)
class RefinementOutput:
    """The output for R proposals.

    Args:
        logits: The logits that it is an object, shape (R,).
        codes: The box's code in the proposal's frame; see `refined_boxes`, shape (R, channels).
    """

    logits: Tensor
    codes: Tensor


@dataclass(frozen=True, eq=False)
class RegionPoints:
    """The points in R proposals.

    Args:
        places: The places in the proposals' frames, shape (R, K, 3).
        features: Whether a point is on an object, its distance, and what it knows, shape
            (R, K, 2 + channels).
        is_empty: Whether there is no point, shape (R,).
    """

    places: Tensor
    features: Tensor
    is_empty: Tensor


class RefinementNetwork(nn.Module):
    """Points of a proposal to confidence and box."""

    def __init__(self, configuration: PointRcnnConfiguration) -> None:
        super().__init__()
        refinement = configuration.refinement
        is_normalised = refinement.is_normalised
        known, channels = configuration.propagation[0][-1], refinement.inputs[-1]
        self.xyz_up_layer = PointLayers([_EXTRAS, *refinement.inputs], is_normalised=is_normalised)
        self.merge_down_layer = PointLayers(
            [channels + known, channels], is_normalised=is_normalised
        )
        self.SA_modules = nn.ModuleList()
        for level in refinement.levels:
            self.SA_modules.append(set_abstraction(channels, level, is_normalised=is_normalised))
            channels = sum(outputs[-1] for outputs in level.channels)
        self.cls_layer, self.reg_layer = (
            point_head(channels, refinement.head, outputs, dropout=0.0, is_normalised=is_normalised)
            for outputs in (1, refinement.coding.channels)
        )
        for layer in self.modules():
            if isinstance(layer, nn.Conv1d | nn.Conv2d):
                nn.init.xavier_normal_(layer.weight)
        nn.init.normal_(self.reg_layer[-1].get_parameter("conv.weight"), 0, _BOX_DEVIATION)

    def forward(self, regions: RegionPoints) -> RefinementOutput:
        """See `region_points`."""
        extras, known = regions.features[..., : _EXTRAS - 3], regions.features[..., _EXTRAS - 3 :]
        raised = self.xyz_up_layer(torch.cat([regions.places, extras], -1))
        features = self.merge_down_layer(torch.cat([raised, known], -1))
        places = regions.places
        for abstraction in self.SA_modules:
            places, features = abstraction(places, features)
        features = features[:, 0]
        return RefinementOutput(self.cls_layer(features)[:, 0], self.reg_layer(features))


@torch.no_grad()
def region_points(
    output: PointOutput, boxes: Sequence[Tensor], configuration: PointRcnnConfiguration
) -> RegionPoints:
    """The points in proposals; nothing is learned through them, as published.

    Args:
        output: The output of the first stage.
        boxes: Proposals of each scan, (M, 7) each.
        configuration: The configuration of the network.

    Returns:
        Those of all scans, one after the other.
    """
    refinement = configuration.refinement
    on_object = (output.scores > configuration.object_score).to(output.features)
    distance = (output.points.norm(dim=-1) / _DISTANCE_SCALE - 0.5).to(output.features)
    known = torch.cat([torch.stack([on_object, distance], -1), output.features], -1)
    places, features, is_empty = [], [], []
    for points, said, rows in zip(output.points, known, boxes, strict=True):
        inside = points_in_boxes(points, enlarged(rows, refinement.margin))
        index = first_inside(inside, refinement.points)
        empty = ~inside.any(1)
        places.append(in_box_frames(points[index], rows).masked_fill(empty[:, None, None], 0.0))
        features.append(said[index].masked_fill(empty[:, None, None], 0.0))
        is_empty.append(empty)
    return RegionPoints(torch.cat(places), torch.cat(features), torch.cat(is_empty))
