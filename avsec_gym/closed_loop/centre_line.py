"""The centre line of a lane: distances along it and to its left, straight beyond its ends."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from avsec_gym.geometry import Floats, wrap_angle


@dataclass(frozen=True, eq=False)
class CentreLine:
    """A line through points, in driving direction.

    Args:
        points: x, y, metres, shape (n, 2); n is 2 or more, and no two neighbours are the same.
    """

    points: Floats

    @cached_property
    def along(self) -> Floats:
        """Distance of each point from the first, metres, shape (n,)."""
        return np.concatenate([[0.0], np.cumsum(self.lengths)])

    @property
    def length(self) -> float:
        """Metres."""
        return float(self.along[-1])

    @cached_property
    def lengths(self) -> Floats:
        """Lengths of the segments, metres, shape (n - 1,)."""
        return np.hypot(*np.diff(self.points, axis=0).T)

    @cached_property
    def directions(self) -> Floats:
        """Unit vectors of the segments, shape (n - 1, 2)."""
        return np.diff(self.points, axis=0) / self.lengths[:, None]

    @cached_property
    def headings(self) -> Floats:
        """Headings at the points, without jumps, shape (n,): the mean of the segments that meet."""
        segments = np.unwrap(np.arctan2(self.directions[:, 1], self.directions[:, 0]))
        middle = 0.5 * (segments[1:] + segments[:-1])
        return np.concatenate([segments[:1], middle, segments[-1:]])

    def heading(self, along: float) -> float:
        """Direction of the line at a distance, radians."""
        if len(self.points) == 2:
            return math.atan2(self._only[3], self._only[2])
        return float(wrap_angle(np.interp(along, self.along, self.headings)))

    def place(self, along: float, left: float = 0.0) -> tuple[float, float]:
        """The point x, y at a distance along the line and to its left, metres."""
        segment = int(np.searchsorted(self.along, along, side="right")) - 1
        segment = min(max(segment, 0), len(self.lengths) - 1)
        (x, y), (dx, dy) = self.points[segment].tolist(), self.directions[segment].tolist()
        ahead = along - float(self.along[segment])
        return x + ahead * dx - left * dy, y + ahead * dy + left * dx

    def pose(self, along: float, left: float = 0.0) -> tuple[float, float, float]:
        """x, y and heading at a distance along the line and to its left."""
        return (*self.place(along, left), self.heading(along))

    def coordinates(self, x: float, y: float) -> tuple[float, float]:
        """Distance along the line of the nearest point of it, and to the left, metres.

        Example:
            >>> CentreLine(np.array([[0.0, 0.0], [10.0, 0.0]])).coordinates(12.0, 1.0)
            (12.0, 1.0)
        """
        if len(self.points) == 2:
            return self._on_straight(x, y)
        relative = np.array([x, y]) - self.points[:-1]
        ahead = (relative * self.directions).sum(axis=1)
        # The first segment runs on backwards, the last one forwards.
        low, high = np.zeros(len(ahead)), self.lengths.copy()
        low[0], high[-1] = -np.inf, np.inf
        inside = np.clip(ahead, low, high)
        apart = relative - inside[:, None] * self.directions
        nearest = int(np.argmin((apart**2).sum(axis=1)))
        across = self.directions[nearest]
        left = across[0] * relative[nearest, 1] - across[1] * relative[nearest, 0]
        return float(self.along[nearest] + inside[nearest]), float(left)

    def _on_straight(self, x: float, y: float) -> tuple[float, float]:
        """`coordinates` on one segment, without arrays."""
        begin_x, begin_y, dx, dy = self._only
        x, y = x - begin_x, y - begin_y
        return x * dx + y * dy, dx * y - dy * x

    @cached_property
    def _only(self) -> tuple[float, float, float, float]:
        """First point and direction of the first segment, as plain numbers."""
        return (*map(float, self.points[0]), *map(float, self.directions[0]))  # type: ignore[return-value]
