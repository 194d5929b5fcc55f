"""Which detection belongs to which object: what is left over was missed, or is a ghost."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from avsec_gym.boxes import Boxes3D
from avsec_gym.geometry import Floats, wrap_angle

LATERAL_REACH = 1.5
"""Metres across the line of sight within which a detection may belong to an object."""
RADIAL_REACH = (2.0, 0.1)
"""The same along the line of sight: metres, and more for each metre of distance."""


def radial_reach(distance: Floats) -> Floats:
    """Metres along the line of sight within which a detection may belong to an object, shape (N,).

    Args:
        distance: The distances of the objects, metres, shape (N,).
    """
    return np.asarray(RADIAL_REACH[0] + RADIAL_REACH[1] * distance)


@dataclass(frozen=True, eq=False)
class Matches:
    """Pairs of objects and detections.

    Args:
        objects: Rows of the objects, shape (K,).
        detections: Rows of their detections, shape (K,).
        ghosts: Rows of the detections of nothing, shape (G,).
    """

    objects: NDArray[np.int64]
    detections: NDArray[np.int64]
    ghosts: NDArray[np.int64]


def match(objects: Boxes3D, detections: Boxes3D) -> Matches:
    """Pair objects with detections so that together they lie as near as possible.

    Overlap, by which precision is counted, would call a box that is 2 m too far a miss and a ghost;
    for driving it is one car at a wrong place.

    Args:
        objects: What is there, in the camera frame.
        detections: What was found, in the camera frame.
    """
    radial, lateral, _ = errors_of(objects, detections)
    reach = radial_reach(np.hypot(*objects.poses[:, :2].T))[:, None]
    apart = (radial / reach) ** 2 + (lateral / LATERAL_REACH) ** 2
    # Pairs out of reach cost more than all others together, and are taken apart again.
    rows, columns = linear_sum_assignment(np.where(apart <= 1, apart, 1e3))
    near = apart[rows, columns] <= 1
    ghosts = np.setdiff1d(np.arange(len(detections)), columns[near])
    return Matches(rows[near], columns[near], ghosts)


def errors_of(objects: Boxes3D, detections: Boxes3D) -> tuple[Floats, Floats, Floats]:
    """Errors of every detection as one of every object, each of shape (objects, detections).

    Returns:
        Radial: metres that the detection lies too far, along the line of sight to the object;
        lateral: metres that it lies too far to the left of it; turn: radians that it is turned too
        far to the left.
    """
    true, found = objects.poses[:, None, :], detections.poses[None, :, :]
    x, y = np.moveaxis(found[..., :2] - true[..., :2], -1, 0)
    bearing = np.arctan2(true[..., 1], true[..., 0])
    return (
        np.cos(bearing) * x + np.sin(bearing) * y,
        np.cos(bearing) * y - np.sin(bearing) * x,
        wrap_angle(found[..., 2] - true[..., 2]),
    )
