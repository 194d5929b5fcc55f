"""The one conversion between the project's plane and highway-env's.

Here x points forward and y to the left, and headings count counter-clockwise.  In highway-env y
points down the screen, to the right of who drives along x, and headings count clockwise.  The
planes are mirror images: y, headings and steering angles change their signs, distances along,
speeds and accelerations stay.  The conversion is its own inverse.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from avsec_gym.geometry import Floats


def mirrored_points(points: ArrayLike) -> Floats:
    """Points of one plane in the other.

    Args:
        points: x, y, shape (..., 2), metres.

    Example:
        >>> mirrored_points([10.0, 3.5]).tolist()
        [10.0, -3.5]
    """
    return np.asarray(points, float) * (1.0, -1.0)


def mirrored_angle(angle: float) -> float:
    """A heading or a steering angle of one plane in the other, radians."""
    return -angle
