"""DSGN's anchors seen from above, and its coding of a box by eight corners, there and back."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from avsec_gym.boxes import Boxes3D
from avsec_gym.geometry import Floats, box_corners
from avsec_gym.perception.detectors.dsgn.configuration import DsgnConfiguration

_ORDER = [0, 3, 2, 1, 4, 7, 6, 5]
"""DSGN goes round a box the other way than `box_corners`: its corner i is the corner _ORDER[i]."""
_LENGTHS = np.array([(0, 3), (1, 2), (4, 7), (5, 6)])
_WIDTHS = np.array([(0, 1), (3, 2), (4, 5), (7, 6)])
_HEIGHTS = np.array([(0, 4), (1, 5), (2, 6), (3, 7)])
"""Edges between corners, each from its front, left or lower end."""


def anchor_footprints(configuration: DsgnConfiguration) -> Floats:
    """The bottom corners of the anchors about their cell's centre.

    Returns:
        Shape (classes, angles, 4, 2): x and z, metres.
    """
    sizes = [(anchor.height, anchor.width, anchor.length) for anchor in configuration.anchors]
    angles = configuration.anchor_angles()
    each = np.repeat(np.array(sizes)[:, None], len(angles), axis=1)
    corners = box_corners(np.zeros_like(each), each, np.tile(angles, (len(sizes), 1)))
    return np.ascontiguousarray(corners[:, :, _ORDER[:4]][..., [0, 2]])


def corners_of_boxes(boxes: Boxes3D) -> Floats:
    """Corners in DSGN's order, shape (N, 8, 3), metres, camera frame.

    (+l/2, +w/2), (+l/2, -w/2), (-l/2, -w/2), (-l/2, +w/2) of the bottom face, then of the top.
    """
    return box_corners(boxes.location, boxes.dimensions, boxes.rotation_y)[:, _ORDER]


def boxes_of_corners(corners: ArrayLike) -> tuple[Floats, Floats, Floats]:
    """The upright boxes that eight free corners mean, as the original reads them.

    The centre is the corners' mean, the sizes are the mean lengths of the edges, the yaw is the
    direction of the mean lengthwise edge.

    Args:
        corners: The corners, shape (N, 8, 3), in the order of `corners_of_boxes`.

    Returns:
        Location (N, 3) of the bottom's centre, dimensions (N, 3) as height, width, length, and
        rotation_y (N,).
    """
    corners = np.asarray(corners, np.float64)
    sizes = [
        np.linalg.norm(_edges(corners, ends), axis=-1).mean(axis=1)
        for ends in (_HEIGHTS, _WIDTHS, _LENGTHS)
    ]
    dimensions = np.stack(sizes, axis=-1)
    location = corners.mean(axis=1)
    location[:, 1] += dimensions[:, 0] / 2
    along = _edges(corners, _LENGTHS).mean(axis=1)
    return location, dimensions, -np.arctan2(along[:, 2], along[:, 0])


def _edges(corners: Floats, ends: np.ndarray) -> Floats:
    return np.asarray(corners[:, ends[:, 0]] - corners[:, ends[:, 1]])
