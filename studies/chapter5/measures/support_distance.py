"""Support distance error: how wrong perception is about the gap between the car and each object.

After Deng et al., "Revisiting 3D Object Detection From an Egocentric Perspective", NeurIPS 2021: a
detected box is judged by the distances to its nearest edge, aside of the car and along its way,
where the car is now and where it will be.  The larger of the two errors counts: a box that is too
long at its far end costs nothing, one that stands a little aside of the truth may cost all.

How this departs from it: there a box whose error is below 0.2 m is a true positive of an average
precision, in which near objects weigh more.  Here a single scene needs a number: the mean error
over objects, weighted by one over their distance as there, in which an object that no box means and
a box that means no object count with `MISSED` metres, as any larger error does.  The car is where
its plan on the truth brings it, not where a person drove.
"""

from __future__ import annotations

import numpy as np

from avsec_gym.box_overlap import rectangle_iou
from avsec_gym.geometry import Floats, rectangle_corners
from avsec_gym.metrics.ghosts import SAME

MISSED = 2.0
"""Metres: the error of what is missed or invented, and the largest of what is found."""
_NEAREST = 1.0
"""Metres: distance below which an object weighs no more."""


def support_distances(rectangles: Floats, poses: Floats) -> Floats:
    """Distances to the nearest edge, aside of the car and along its way.

    Args:
        rectangles: x, y, length, width, heading of N objects, shape (N, 5), ego frame.
        poses: x, y, heading of the car's centre at T times, shape (T, 3).

    Returns:
        Metres, shape (T, N, 2), aside and along; 0 where the object lies on the car's axis.

    Example:
        >>> support_distances(np.array([[10.0, 3, 4, 2, 0]]), np.zeros((1, 3)))
        array([[[2., 8.]]])
    """
    corners = rectangle_corners(rectangles[:, [0, 1, 4]], rectangles[:, 2], rectangles[:, 3])
    away = corners[None] - poses[:, None, None, :2]
    cos, sin = np.cos(poses[:, None, None, 2]), np.sin(poses[:, None, None, 2])
    ahead = cos * away[..., 0] + sin * away[..., 1]
    aside = cos * away[..., 1] - sin * away[..., 0]
    offsets = np.stack([aside, ahead], axis=-1)  # (T, N, corners, 2)
    # Of corners on both sides of an axis the axis is touched.
    low, high = offsets.min(axis=2), offsets.max(axis=2)
    return np.maximum(np.maximum(low, -high), 0.0)


def support_distance_error(real: Floats, seen: Floats, poses: Floats) -> float:
    """The mean error of the gap to every real or invented object, near ones weighing more.

    Args:
        real: x, y, length, width, heading of the real objects, shape (N, 5), ego frame.
        seen: The same of the believed ones, shape (M, 5).
        poses: x, y, heading of the car's centre at the times that count, shape (T, 3).

    Returns:
        Metres, from 0 to `MISSED`; NaN where nothing is there and nothing is seen.
    """
    overlap = rectangle_iou(real, seen)
    # The best pairs first, each object and each box once.
    pairs: list[tuple[int, int]] = []
    for flat in np.argsort(-overlap, axis=None, kind="stable"):
        i, j = np.unravel_index(flat, overlap.shape)
        if overlap[i, j] < SAME:
            break
        if all(i != known and j != box for known, box in pairs):
            pairs.append((int(i), int(j)))
    errors = np.full(len(real), MISSED)
    if pairs:
        rows, boxes = np.transpose(pairs)
        wrong = np.abs(support_distances(real[rows], poses) - support_distances(seen[boxes], poses))
        errors[rows] = np.minimum(wrong.max(axis=2).mean(axis=0), MISSED)
    invented = np.delete(seen, [box for _, box in pairs], axis=0)
    everything = np.concatenate([real, invented])
    if not len(everything):
        return np.nan
    errors = np.concatenate([errors, np.full(len(invented), MISSED)])
    distance = np.hypot(*(everything[:, :2] - poses[0, :2]).T)
    return float(np.average(errors, weights=1 / np.maximum(distance, _NEAREST)))
