"""Between KITTI's boxes in the camera frame and rectangles that a LiDAR sees from above."""

from __future__ import annotations

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import Calibration, Points
from avsec_gym.geometry import Floats, transform_points
from avsec_gym.perception.detectors.boxes_in_view import boxes_in_view

LIDAR_HEIGHT = 1.73
"""Metres above a flat road, of KITTI's sensor."""
_AROUND = 1.0
"""Metres about a rectangle in which its ground is looked for."""
_FEWEST_POINTS = 20
_LOWEST_SHARE = 10.0
"""Percent of the points about an object that may lie under its ground: stray returns."""


def seen_from_above(boxes: Boxes3D, calibration: Calibration) -> Floats:
    """The rectangles of boxes in the velodyne frame, x, y, length, width, heading: shape (N, 5)."""
    matrix = calibration.camera_to_velodyne
    x, y, _ = transform_points(matrix, boxes.location).T
    ahead = np.stack([np.cos(boxes.rotation_y), 0 * x, -np.sin(boxes.rotation_y)], axis=-1)
    forward, left, _ = (ahead @ matrix[:3, :3].T).T
    return np.stack([x, y, boxes.length, boxes.width, np.arctan2(left, forward)], axis=-1)


def upright_boxes(
    rectangles: Floats,
    ground: Floats,
    score: Floats,
    category: str,
    height: float,
    calibration: Calibration,
    size: tuple[int, int] | None = None,
) -> Boxes3D:
    """Boxes that stand on rectangles.

    Args:
        rectangles: The rectangles, shape (N, 5), velodyne frame.
        ground: z of the ground under each, shape (N,).
        score: The scores, shape (N,).
        category: The category of all of them.
        height: The height of all of them, metres.
        calibration: The calibration of the rig; without camera 2, boxes have no `box2d`.
        size: Height and width of that camera's image, to which 2D boxes are clipped; boxes of
            which it shows nothing are left out, as in KITTI's labels.  None: nothing is clipped.
    """
    x, y, length, width, heading = rectangles.T
    matrix = calibration.velodyne_to_camera
    location = transform_points(matrix, np.stack([x, y, ground], axis=-1))
    ahead = np.stack([np.cos(heading), np.sin(heading), 0 * x], axis=-1) @ matrix[:3, :3].T
    rotation_y = np.arctan2(-ahead[:, 2], ahead[:, 0])
    dimensions = np.stack([np.full_like(length, height), width, length], axis=-1)
    return boxes_in_view(location, dimensions, rotation_y, score, category, calibration, size)


def ground_heights(points: Points, rectangles: Floats) -> Floats:
    """How high the ground under rectangles is: z in the velodyne frame, shape (N,).

    A tenth of the points within a metre of a rectangle is lower; where there are few
    points, the road is flat.
    """
    heights = np.full(len(rectangles), -LIDAR_HEIGHT)
    for number, (x, y, length, width, _) in enumerate(rectangles):
        reach = np.hypot(length, width) / 2 + _AROUND
        near = (np.abs(points[:, 0] - x) < reach) & (np.abs(points[:, 1] - y) < reach)
        if near.sum() >= _FEWEST_POINTS:
            heights[number] = np.percentile(points[near, 2], _LOWEST_SHARE)
    return heights
