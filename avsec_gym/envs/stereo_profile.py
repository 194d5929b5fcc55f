"""What stands around the car, as its two cameras measure it without a network: a few numbers."""

from __future__ import annotations

import numpy as np

from avsec_gym.attacks.attack import LEFT
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats
from avsec_gym.perception.depth.sgbm import SemiGlobalMatching

SECTORS = 64
"""Number of directions that are distinguished."""
BEARING = 0.7
"""Radians to either side of the camera's axis, about what KITTI's cameras see."""
FARTHEST = 60
"""Metres; depths of whole metres up to there are distinguished."""
SIZE = 2 * SECTORS

_HEIGHTS = (0.3, 2.5)
"""Metres above the ground between which something is in a car's way."""
_CAMERA = 1.65
"""Metres of the camera above the ground."""
_LEAST, _MOST = 0.1, 4.0
"""Square metres: what counts as something, and what the profile's areas are relative to."""


def stereo_profile(frame: SensorFrame) -> Floats:
    """The nearest thing that stands up in each direction, by semi-global matching.

    Args:
        frame: A frame with the images of cameras 2 and 3.

    Returns:
        Shape (SIZE,), in [0, 1].  For each of 64 equal sectors of bearing, from 0.7 rad to the left
        to 0.7 rad to the right, the depth / 60 m of the nearest metre of depth in which 0.1 m2 or
        more stand 0.3 to 2.5 m above a flat ground, 1 where there is none; then, sector by sector,
        the area that stands there / 4 m2, at most 1, 0 where there is none.
    """
    depth = SemiGlobalMatching().disparity(frame).depth
    projection = frame.calibration.projection(LEFT)
    focal, (u0, v0) = projection[0, 0], projection[:2, 2]
    rows, columns = np.nonzero(np.isfinite(depth) & (depth > 2.0) & (depth < FARTHEST))
    z = depth[rows, columns].astype(float)
    # Where each pixel is, and how much of a surface that faces the camera it shows.
    height = _CAMERA - (rows - v0) * z / focal
    share = (np.arctan2(columns - u0, focal) + BEARING) / (2 * BEARING)
    stands = (height > _HEIGHTS[0]) & (height < _HEIGHTS[1]) & (share >= 0) & (share < 1)
    sector, metre = (SECTORS * share[stands]).astype(int), z[stands].astype(int)
    area = np.zeros((SECTORS, FARTHEST))
    np.add.at(area, (sector, metre), (z[stands] / focal) ** 2)
    # The nearest of what is large enough in each sector.
    there = area >= _LEAST
    nearest = there.argmax(axis=1)
    seen = there.any(axis=1)
    distance = np.where(seen, nearest / FARTHEST, 1.0)
    shown = np.where(seen, np.minimum(area[np.arange(SECTORS), nearest] / _MOST, 1.0), 0.0)
    return np.concatenate([distance, shown])
