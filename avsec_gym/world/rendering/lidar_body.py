"""Which pulses of a LiDAR on KITTI's car end on that car itself."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from avsec_gym.world.rendering.lidar import Lidar

_BODY = (
    (162.0, 198.0, -90.0, -18.3),
    (199.0, 205.0, -90.0, -20.0),
    (155.0, 161.0, -90.0, -21.0),
    (161.0, 165.0, -18.3, -15.0),
    (195.0, 199.0, -18.3, -15.0),
    (227.0, 233.0, -90.0, -19.6),
    (127.0, 133.0, -90.0, -19.6),
    (281.0, 297.0, -22.3, -15.9),
    (-15.0, 18.0, -90.0, -20.4),
    (-19.0, 22.0, -90.0, -22.2),
    (-42.0, -33.0, -90.0, -22.2),
    (38.0, 46.0, -90.0, -22.2),
)
"""Azimuths to the left of ahead from and to, elevations from and to, all in degrees, in which
eight of KITTI's scans hold next to nothing: roof, racks, cameras, aerials."""


@lru_cache(maxsize=4)
def free_of_body(lidar: Lidar) -> NDArray[np.bool_]:
    """Which pulses the body of its own vehicle does not stop, shape (64 * columns,)."""
    x, y, z = lidar.directions.T
    azimuth, elevation = np.degrees(np.arctan2(y, x)), np.degrees(np.arcsin(z))
    free = np.ones(len(x), bool)
    for first, last, low, high in _BODY:
        across = (azimuth - first) % 360.0 < last - first
        free &= ~(across & (elevation > low) & (elevation < high))
    return free
