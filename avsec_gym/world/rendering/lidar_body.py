"""Which pulses of a LiDAR on KITTI's car end on that car itself."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from avsec_gym.world.rendering.lidar import Lidar

_BODY = (
    (162.0, 198.0, -90.0, -19.2),
    (198.0, 204.0, -90.0, -20.1),
    (156.0, 162.0, -90.0, -20.9),
    (153.0, 156.0, -90.0, -22.2),
    (159.0, 163.0, -19.2, -13.9),
    (199.0, 203.0, -19.2, -13.9),
    (230.5, 235.5, -90.0, -21.0),
    (129.0, 133.0, -90.0, -21.0),
    (283.0, 297.0, -23.4, -16.8),
    (-15.0, 15.0, -90.0, -21.8),
    (-19.0, 18.0, -90.0, -23.4),
    (-42.0, -33.0, -90.0, -23.4),
    (38.0, 46.0, -90.0, -23.4),
)
"""Azimuths to the left of ahead from and to, tilts of lasers from and to, all in degrees, in which
nine of KITTI's scans hold next to nothing: roof, racks, cameras, aerials."""


@lru_cache(maxsize=64)
def free_of_body(lidar: Lidar) -> NDArray[np.bool_]:
    """Which pulses the body of its own vehicle does not stop, shape (64 * columns,)."""
    azimuth, elevation = np.degrees(lidar.head), np.degrees(lidar.lasers.elevation)
    free = np.ones((len(elevation), len(azimuth)), bool)
    for first, last, low, high in _BODY:
        across = (azimuth - first) % 360.0 < last - first
        free &= ~np.outer((elevation > low) & (elevation < high), across)
    return free.reshape(-1)
