"""From DSGN's output to boxes: the best anchors, one for each object, as KITTI writes objects."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from avsec_gym.box_overlap import ground_rectangles
from avsec_gym.boxes import Boxes3D
from avsec_gym.geometry import Floats, project, wrap_angle
from avsec_gym.perception.detectors.dsgn.anchors import boxes_of_corners, corners_of_boxes
from avsec_gym.perception.detectors.dsgn.configuration import DsgnConfiguration
from avsec_gym.perception.detectors.dsgn.decoding_rule import DsgnDecodingRule
from avsec_gym.perception.detectors.dsgn.network import DsgnOutput
from avsec_gym.perception.nn.box_voting import voted_boxes
from avsec_gym.perception.nn.rotated_nms import rotated_nms

_NEAR = 0.1
"""Metres: corners behind the camera are projected as if this far before it."""


def decode(
    output: DsgnOutput,
    configuration: DsgnConfiguration,
    projections: Floats,
    size: tuple[int, int],
    rule: DsgnDecodingRule = DsgnDecodingRule(),
) -> list[Boxes3D]:
    """The boxes of each pair, best score first, with `box2d` and `alpha`.

    Args:
        output: The output of the network.
        configuration: The network's anchors and grid.
        projections: P of the left cameras for their own images, shape (B, 3, 4).
        size: Height and width of these images, pixels.
        rule: What becomes a box.
    """
    probabilities = torch.sigmoid(output.class_logits)
    scores = probabilities
    if rule.score_times_centerness:
        scores = scores * torch.sigmoid(output.centerness)[:, :, None]
    if rule.fit_share and output.fit is not None:
        fit = torch.sigmoid(output.fit)
        scores = scores ** (1 - rule.fit_share) * fit**rule.fit_share
    allowed = (probabilities > rule.least_score) & (scores >= rule.least_score)
    return [
        _boxes(
            _candidates(i, scores[i], allowed[i], output, configuration, rule),
            configuration,
            projections[i],
            size,
            rule,
        )
        for i in range(len(scores))
    ]


@dataclass(frozen=True, eq=False)
class _Candidates:
    """The best N anchors of an image, sorted: scores (N,), classes (N,), boxes as of `Boxes3D`."""

    scores: Floats
    classes: NDArray[np.int64]
    location: Floats
    dimensions: Floats
    rotation_y: Floats


def _candidates(
    image: int,
    scores: Tensor,
    allowed: Tensor,
    output: DsgnOutput,
    configuration: DsgnConfiguration,
    rule: DsgnDecodingRule,
) -> _Candidates:
    places = allowed.nonzero(as_tuple=True)
    best = torch.argsort(scores[places], descending=True, stable=True)[: rule.candidates]
    angle, kind, row, column = (part[best] for part in places)
    index = (torch.full_like(angle, image), angle, kind, row, column)
    offsets = output.boxes.at(index).double().cpu().numpy()
    classes, rows, columns = (part.cpu().numpy() for part in (kind, row, column))
    heights = np.array([anchor.centre_y for anchor in configuration.anchors])
    place = (
        configuration.grid.x.centres()[columns],
        heights[classes],
        configuration.grid.z.centres()[rows],
    )
    location, dimensions, rotation_y = boxes_of_corners(offsets + np.stack(place, -1)[:, None])
    if output.reversal is not None:
        reverse = (output.reversal[index] > 0).cpu().numpy()
        rotation_y = wrap_angle(rotation_y + np.pi * reverse)
    found = scores[angle, kind, row, column].double().cpu().numpy()
    return _Candidates(found, classes, location, dimensions, rotation_y)


def _boxes(
    found: _Candidates,
    configuration: DsgnConfiguration,
    projection: Floats,
    size: tuple[int, int],
    rule: DsgnDecodingRule,
) -> Boxes3D:
    """What stays of the candidates, voted on where the rule asks for it."""
    location, dimensions, rotation_y = (
        part.copy() for part in (found.location, found.dimensions, found.rotation_y)
    )
    rectangles = ground_rectangles(location, dimensions, rotation_y)
    stays = np.zeros(len(location), bool)
    for kind in np.unique(found.classes):
        # Suppression, and voting, among the boxes of a class.
        members = np.flatnonzero(found.classes == kind)
        scores = found.scores[members]
        kept = rotated_nms(rectangles[members], scores, rule.most_overlap)
        stays[members[kept]] = True
        if rule.voting_overlap is not None:
            rows = members[kept]
            location[rows], dimensions[rows], rotation_y[rows] = voted_boxes(
                found.location[members], found.dimensions[members], found.rotation_y[members],
                scores, kept, overlap=rule.voting_overlap, turn=rule.voting_turn,
            )  # fmt: skip
    # Candidates come best first: of all classes together, the best remain.
    kept = np.flatnonzero(stays)[: rule.most_boxes]
    names = np.array([anchor.category for anchor in configuration.anchors])
    boxes = Boxes3D(
        location,
        dimensions,
        rotation_y,
        found.scores,
        names[found.classes],
        alpha=wrap_angle(rotation_y - np.arctan2(location[:, 0], location[:, 2])),
    )[kept]
    return replace(boxes, box2d=_image_boxes(corners_of_boxes(boxes), projection, size))


def _image_boxes(corners: Floats, projection: Floats, size: tuple[int, int]) -> Floats:
    """Rectangles around the projected corners, clipped to the image, shape (N, 4)."""
    before = corners.copy()
    before[..., 2] = np.maximum(before[..., 2], _NEAR)
    pixels, _ = project(projection, before)
    pixels = np.clip(pixels, 0.0, [size[1] - 1.0, size[0] - 1.0])
    return np.concatenate([pixels.min(axis=1), pixels.max(axis=1)], axis=-1)
