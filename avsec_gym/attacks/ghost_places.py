"""Where a pasted object may stand: on ground that the attacked scan shows, free of objects."""

from __future__ import annotations

import numpy as np

from avsec_gym.attacks.object_scan import ObjectScan, object_pose
from avsec_gym.errors import DataError
from avsec_gym.frame import Points
from avsec_gym.geometry import Floats, transform_points

_TRIALS = 200
_AROUND = 1.0
_FEWEST = 10
_FLAT = 0.3
"""Metres that the ground may rise in the box's outline."""


def random_place(
    points: Points,
    scan: ObjectScan,
    randomness: np.random.Generator,
    distance: tuple[float, float] = (6.0, 40.0),
) -> Floats:
    """A random pose at which an object stands on the ground, with its scanned sides to the LiDAR.

    Args:
        points: The scan that is attacked, velodyne frame, shape (M, 4).
        scan: The scan of the object.
        randomness: Draws bearing and distance.
        distance: Least and greatest distance from the LiDAR, metres.

    Returns:
        From the object's own frame to the velodyne frame, shape (4, 4).

    Raises:
        DataError: No such place was found in 200 draws.
    """
    height, width, length = scan.dimensions
    half = np.array([length, width]) / 2
    ahead, left = scan.seen_from
    for _ in range(_TRIALS):
        reach, bearing = randomness.uniform(*distance), randomness.uniform(-np.pi, np.pi)
        # From the object the LiDAR is seen backwards along the bearing.
        heading = bearing + np.pi - np.arctan2(left, ahead)
        place = np.array([reach * np.cos(bearing), reach * np.sin(bearing), heading])
        own = transform_points(np.linalg.inv(object_pose(place, 0.0)), points[:, :3])
        about = (np.abs(own[:, :2]) <= half + _AROUND).all(axis=1)
        if about.sum() < _FEWEST:
            continue
        bottom = float(np.percentile(own[about, 2], 20))
        inside = (np.abs(own[:, :2]) <= half).all(axis=1) & (own[:, 2] < bottom + height)
        if not (own[inside, 2] > bottom + _FLAT).any():
            return object_pose(place, bottom)
    raise DataError(
        f"No ground without an object is seen {distance[0]:g} to {distance[1]:g} m away.",
        remedy="Widen the range of distances, or take another frame.",
    )
