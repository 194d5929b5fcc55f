"""Poses in the world frame and as the car sees them: x forward, y left, headings to the left."""

from __future__ import annotations

import math

import numpy as np

from avsec_gym.geometry import Floats

Pose = tuple[float, float, float]
"""x, y (m), heading (rad)."""


def seen_from(pose: Pose, poses: Floats) -> Floats:
    """World poses as they are seen from a pose: x forward, y left.

    Args:
        pose: x, y, heading of the observer.
        poses: World poses, shape (N, 3).
    """
    x, y, heading = pose
    cos, sin = math.cos(heading), math.sin(heading)
    apart = poses[:, :2] - (x, y)
    return np.column_stack(
        [
            cos * apart[:, 0] + sin * apart[:, 1],
            cos * apart[:, 1] - sin * apart[:, 0],
            poses[:, 2] - heading,
        ]
    )


def in_world(pose: Pose, poses: Floats) -> Floats:
    """The inverse of `seen_from`: poses seen from a pose in the world frame."""
    x, y, heading = pose
    cos, sin = math.cos(heading), math.sin(heading)
    return np.column_stack(
        [
            x + cos * poses[:, 0] - sin * poses[:, 1],
            y + sin * poses[:, 0] + cos * poses[:, 1],
            poses[:, 2] + heading,
        ]
    )
