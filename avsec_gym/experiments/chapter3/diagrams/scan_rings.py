"""A scan with fewer rings: what a LiDAR of fewer lasers sees."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avsec_gym.attacks.lidar_spoofing import RING_ELEVATIONS
from avsec_gym.frame import Points

_MIDDLES = (RING_ELEVATIONS[1:] + RING_ELEVATIONS[:-1]) / 2


def rings_of(points: Points) -> NDArray[np.intp]:
    """The ring of each point, by the nearest elevation of a Velodyne HDL-64E, 0 the highest.

    Args:
        points: Velodyne frame, shape (M, 4).

    Returns:
        Shape (M,), 0 to 63.
    """
    elevation = np.arctan2(points[:, 2], np.hypot(points[:, 0], points[:, 1]))
    return np.asarray(np.searchsorted(-_MIDDLES, -elevation), np.intp)


def kept_rings(points: Points, most: int) -> frozenset[int] | None:
    """The rings that leave a number of points at most, evenly from top to bottom; at least one.

    Args:
        points: The scan, velodyne frame, shape (M, 4).
        most: Number of points; 0: all.

    Returns:
        Their numbers; None: all are kept.
    """
    if not most or len(points) <= most:
        return None
    rings = len(RING_ELEVATIONS)
    counts = np.bincount(rings_of(points), minlength=rings)
    for count in range(rings, 0, -1):
        # The middles of as many equal parts.
        chosen = ((2 * np.arange(count) + 1) * rings // (2 * count)).astype(int)
        if counts[chosen].sum() <= most:
            break
    return frozenset(chosen.tolist())


def on_rings(points: Points, rings: frozenset[int] | None) -> Points:
    """The points of some rings, in their order; None: all.

    Args:
        points: The scan, velodyne frame, shape (M, 4).
        rings: The rings that are kept, as of `kept_rings`.
    """
    if rings is None:
        return points
    return np.asarray(points[np.isin(rings_of(points), sorted(rings))])
