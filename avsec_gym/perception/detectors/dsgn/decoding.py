"""From DSGN's output to boxes: the best anchors, one for each object, as KITTI writes objects."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from avsec_gym.box_overlap import ground_rectangles
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats, project, wrap_angle
from avsec_gym.perception.detectors.dsgn.anchors import boxes_of_corners
from avsec_gym.perception.detectors.dsgn.configuration import DsgnConfiguration
from avsec_gym.perception.detectors.dsgn.network import DsgnOutput
from avsec_gym.perception.nn.rotated_nms import rotated_nms

_NEAR = 0.1
"""Metres: corners behind the camera are projected as if this far before it."""


@dataclass(frozen=True)
class DecodingRule:
    """Which anchors become boxes; the defaults are those of the original car detector."""

    least_score: float = 0.05
    candidates: int = 300
    """Anchors of an image, best first, that enter the suppression."""
    most_overlap: float = 0.6
    """Intersection over union seen from above of two boxes of one class that may both stay."""
    most_boxes: int = 30
    """In an image."""
    score_times_centerness: bool = False

    def __post_init__(self) -> None:
        if not (0 < self.least_score < 1 and 0 <= self.most_overlap <= 1):
            raise ConfigurationError(f"scores and overlaps are shares, got {self}")
        if min(self.candidates, self.most_boxes) < 1:
            raise ConfigurationError(f"an image needs candidates and boxes, got {self}")


def decode(
    output: DsgnOutput,
    configuration: DsgnConfiguration,
    projections: Floats,
    size: tuple[int, int],
    rule: DecodingRule = DecodingRule(),
) -> list[Boxes3D]:
    """The boxes of each pair, best score first, with `box2d` and `alpha`.

    Args:
        output: Of the network.
        configuration: Its anchors and grid.
        projections: P of the left cameras for their own images, shape (B, 3, 4).
        size: Height and width of these images, pixels.
        rule: What becomes a box.
    """
    probabilities = torch.sigmoid(output.class_logits)
    scores = probabilities
    if rule.score_times_centerness:
        scores = scores * torch.sigmoid(output.centerness)[:, :, None]
    allowed = (probabilities > rule.least_score) & (scores >= rule.least_score)
    return [
        _boxes(
            *_candidates(scores[i], allowed[i], output.corners[i], configuration, rule),
            configuration,
            projections[i],
            size,
            rule,
        )
        for i in range(len(scores))
    ]


def _candidates(
    scores: Tensor,
    allowed: Tensor,
    corners: Tensor,
    configuration: DsgnConfiguration,
    rule: DecodingRule,
) -> tuple[Floats, np.ndarray, Floats]:
    """Scores (N,), classes (N,) and corners (N, 8, 3) of an image's best anchors, sorted."""
    angle, kind, row, column = allowed.nonzero(as_tuple=True)
    found = scores[angle, kind, row, column]
    best = torch.argsort(found, descending=True, stable=True)[: rule.candidates]
    angle, kind, row, column = (part[best] for part in (angle, kind, row, column))
    offsets = corners[angle, kind, :, :, row, column].double().cpu().numpy()
    classes, rows, columns = (part.cpu().numpy() for part in (kind, row, column))
    heights = np.array([anchor.centre_y for anchor in configuration.anchors])
    place = (
        configuration.grid.x.centres()[columns],
        heights[classes],
        configuration.grid.z.centres()[rows],
    )
    return found[best].double().cpu().numpy(), classes, offsets + np.stack(place, -1)[:, None]


def _boxes(
    scores: Floats,
    classes: np.ndarray,
    corners: Floats,
    configuration: DsgnConfiguration,
    projection: Floats,
    size: tuple[int, int],
    rule: DecodingRule,
) -> Boxes3D:
    location, dimensions, rotation_y = boxes_of_corners(corners)
    rectangles = ground_rectangles(location, dimensions, rotation_y)
    stays = np.zeros(len(scores), bool)
    for kind in np.unique(classes):
        members = np.flatnonzero(classes == kind)
        stays[members[rotated_nms(rectangles[members], scores[members], rule.most_overlap)]] = True
    kept = np.flatnonzero(stays)[: rule.most_boxes]
    names = np.array([anchor.category for anchor in configuration.anchors])
    boxes = Boxes3D(
        location,
        dimensions,
        rotation_y,
        scores,
        names[classes],
        box2d=_image_boxes(corners, projection, size),
        alpha=wrap_angle(rotation_y - np.arctan2(location[:, 0], location[:, 2])),
    )
    return boxes[kept]


def _image_boxes(corners: Floats, projection: Floats, size: tuple[int, int]) -> Floats:
    """Rectangles around the projected corners, clipped to the image, shape (N, 4)."""
    before = corners.copy()
    before[..., 2] = np.maximum(before[..., 2], _NEAR)
    pixels, _ = project(projection, before)
    pixels = np.clip(pixels, 0.0, [size[1] - 1.0, size[0] - 1.0])
    return np.concatenate([pixels.min(axis=1), pixels.max(axis=1)], axis=-1)
