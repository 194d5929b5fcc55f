"""What `avsec/GhostObject-v1` reports of each place where the attacker can put a ghost."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from avsec_gym.geometry import Floats, rectangle_corners

SIZE = 6
"""Numbers for each place."""
MOST_ROOM = 6.0
"""Metres; more is not distinguished."""

_REACH = np.array([20.0, 8.0])
"""Metres ahead and to the side that 1 stands for."""
_BESIDE, _BEFORE = 2.5, 1.2
"""Half the length and half the width of the strips in which room is measured, m: those that a
passing car of 4.5 x 1.6 m sweeps, and a little more than the half."""
_OUTLINE = 9
"""Points on each side of an object."""


@dataclass(frozen=True, eq=False)
class PlaceFeatures:
    """Places with the room around them.

    Args:
        positions: x ahead and y to the left, m, shape (..., 2).
        room: Distance from the place's middle to the nearest real object to the left, to the right,
            ahead and behind, m, at most `MOST_ROOM`, shape (..., 4).  To the sides, objects within
            2.5 m along the road count, ahead and behind those within 1.2 m to either side.

    Example:
        >>> features = PlaceFeatures(np.array([[10.0, -2.0]]), np.array([[1.5, 6.0, 6.0, 3.0]]))
        >>> features.encode().tolist()
        [[0.5, -0.25, 0.25, 1.0, 1.0, 0.5]]
        >>> PlaceFeatures.decode(features.encode()).room.tolist()
        [[1.5, 6.0, 6.0, 3.0]]
    """

    positions: Floats
    room: Floats

    @classmethod
    def among(cls, positions: Floats, poses: Floats, half_sizes: Floats) -> PlaceFeatures:
        """The room that real objects leave around places.

        Args:
            positions: Shape (S, 2), m.
            poses: x, y, cos and sin of the heading of N rectangles, shape (N, 4).
            half_sizes: Half length and half width, m, shape (N, 2).
        """
        outline = _outlines(poses, half_sizes)
        away = outline[None] - positions[:, None]
        along, across = away[..., 0], away[..., 1]
        beside, before = np.abs(along) <= _BESIDE, np.abs(across) <= _BEFORE
        room = [
            np.where(where & (distance >= 0), distance, MOST_ROOM).min(axis=1, initial=MOST_ROOM)
            for where, distance in (
                (beside, across),
                (beside, -across),
                (before, along),
                (before, -along),
            )
        ]
        return cls(positions, np.stack(room, axis=1))

    def encode(self) -> Floats:
        """The features as the observation has them, in [-1, 1], shape (..., SIZE)."""
        near = np.clip(self.positions / _REACH, -1.0, 1.0)
        return np.concatenate([near, self.room / MOST_ROOM], axis=-1)

    @classmethod
    def decode(cls, features: Floats) -> PlaceFeatures:
        """The inverse of `encode`, from shape (..., SIZE)."""
        features = np.asarray(features, float)
        return cls(features[..., :2] * _REACH, features[..., 2:] * MOST_ROOM)


def _outlines(poses: Floats, half_sizes: Floats) -> Floats:
    """Points on the sides of rectangles, shape (4 N _OUTLINE, 2)."""
    headings = np.arctan2(poses[:, 3], poses[:, 2])
    corners = rectangle_corners(
        np.column_stack([poses[:, :2], headings]), 2 * half_sizes[:, 0], 2 * half_sizes[:, 1]
    )
    share = np.linspace(0.0, 1.0, _OUTLINE)[:, None]
    sides = corners[:, :, None] + share * (np.roll(corners, -1, axis=1) - corners)[:, :, None]
    return sides.reshape(-1, 2)
