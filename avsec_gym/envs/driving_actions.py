"""What a driver wants, as an action of `avsec/ClosedLoop-v0`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avsec_gym.closed_loop.road_frame import mirrored_angle

Span = tuple[float, float]


def driving_action(wanted: tuple[float, float], ranges: tuple[Span, Span]) -> NDArray[np.float32]:
    """The action in [-1, 1] that stands for what is wanted, cut where that is out of range.

    Args:
        wanted: Acceleration, m/s2, and steering angle, radians to the left.
        ranges: What -1 and 1 stand for: m/s2, and radians to the right, as highway-env steers.

    Returns:
        Shape (2,).

    Example:
        >>> driving_action((4.0, 0.5), ((-8.0, 8.0), (-1.0, 1.0))).tolist()
        [0.5, -0.5]
    """
    acceleration, steering = wanted
    values = (acceleration, mirrored_angle(steering))
    scaled = [_scaled(value, *span) for value, span in zip(values, ranges, strict=True)]
    return np.array(scaled, np.float32)


def _scaled(value: float, low: float, high: float) -> float:
    """From [low, high] to [-1, 1], cut."""
    return min(max(2.0 * (value - low) / (high - low) - 1.0, -1.0), 1.0)
