"""Boxes that were found in a scan, as KITTI has them: with what the camera shows of them."""

from __future__ import annotations

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import Calibration
from avsec_gym.geometry import Floats, box_corners, project, wrap_angle

_NEAR = 0.1
"""Metres: corners behind the camera are projected as if this far before it."""


def boxes_in_view(
    location: Floats,
    dimensions: Floats,
    rotation_y: Floats,
    score: Floats,
    category: str,
    calibration: Calibration,
    size: tuple[int, int] | None = None,
) -> Boxes3D:
    """Boxes with `alpha` and, by projecting their corners into camera 2, `box2d`.

    Args:
        location: Bottom centres in the camera frame, shape (N, 3).
        dimensions: Height, width, length, shape (N, 3).
        rotation_y: The headings, shape (N,).
        score: The scores, shape (N,).
        category: The category of all of them.
        calibration: The calibration of the rig; without camera 2, boxes have no `box2d`.
        size: Height and width of that camera's image, to which 2D boxes are clipped; boxes of
            which it shows nothing are left out, as in KITTI's labels.  None: nothing is clipped.
    """
    has_camera = 2 in calibration.cameras
    corners = box_corners(location, dimensions, rotation_y)
    box2d = _image_boxes(corners, calibration.projection(2), size) if has_camera else None
    boxes = Boxes3D(
        location,
        dimensions,
        rotation_y,
        score,
        np.full(len(location), category),
        box2d=box2d,
        alpha=wrap_angle(rotation_y - np.arctan2(location[:, 0], location[:, 2])),
    )
    if box2d is None:
        return boxes
    return boxes[(box2d[:, 2] > box2d[:, 0]) & (box2d[:, 3] > box2d[:, 1])]


def _image_boxes(corners: Floats, projection: Floats, size: tuple[int, int] | None) -> Floats:
    """Rectangles around projected corners, shape (N, 4)."""
    before = corners.copy()
    before[..., 2] = np.maximum(before[..., 2], _NEAR)
    pixels, _ = project(projection, before)
    if size is not None:
        pixels = np.clip(pixels, 0.0, [size[1] - 1.0, size[0] - 1.0])
    return np.concatenate([pixels.min(axis=1), pixels.max(axis=1)], axis=-1)
