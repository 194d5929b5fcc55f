"""The centre line of a lane: distances along it and to its left, straight beyond its ends."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from avsec_gym.geometry import Floats, wrap_angle
from avsec_gym.kernels import kernel

X, Y, ALONG, HEADING, LENGTH, AHEAD_X, AHEAD_Y = range(7)
"""Columns of the points of lines, as `coordinates` reads them."""


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

    def poses(self, along: Floats, left: Floats) -> Floats:
        """`pose` at n distances, shape (n, 3); headings go on without jumps from the first."""
        segment = np.searchsorted(self.along, along, side="right") - 1
        segment = np.clip(segment, 0, len(self.lengths) - 1)
        (x, y), (dx, dy) = self.points[segment].T, self.directions[segment].T
        ahead = along - self.along[segment]
        headings = np.interp(along, self.along, self.headings)
        return np.column_stack([x + ahead * dx - left * dy, y + ahead * dy + left * dx, headings])

    def coordinates(self, x: float, y: float) -> tuple[float, float]:
        """Distance along the line of the nearest point of it, and to the left, metres.

        Example:
            >>> CentreLine(np.array([[0.0, 0.0], [10.0, 0.0]])).coordinates(12.0, 1.0)
            (12.0, 1.0)
        """
        if len(self.points) == 2:
            return self._on_straight(x, y)
        return coordinates(self.table, 0, len(self.table), x, y)

    def _on_straight(self, x: float, y: float) -> tuple[float, float]:
        """`coordinates` on one segment, without arrays."""
        begin_x, begin_y, dx, dy = self._only
        x, y = x - begin_x, y - begin_y
        return x * dx + y * dy, dx * y - dy * x

    @cached_property
    def table(self) -> Floats:
        """All of it as `coordinates` reads it, shape (n, 7)."""
        lengths = np.append(self.lengths, 0.0)
        directions = np.vstack([self.directions, [0.0, 0.0]])
        return np.column_stack([self.points, self.along, self.headings, lengths, directions])

    @cached_property
    def _only(self) -> tuple[float, float, float, float]:
        """First point and direction of the first segment, as plain numbers."""
        return (*map(float, self.points[0]), *map(float, self.directions[0]))  # type: ignore[return-value]


@kernel(nogil=True)
def coordinates(points: Floats, begin: int, end: int, x: float, y: float) -> tuple[float, float]:
    """`CentreLine.coordinates` of one of many lines.

    Args:
        points: Points of lines, one line after the other: x, y, distance along the line, the line's
            heading without jumps; length and direction of the segment from here on; shape (P, 7).
        begin: The line's first point.
        end: The one after its last.
        x: The place along x, metres.
        y: The place along y, metres.
    """
    along, left, least = 0.0, 0.0, np.inf
    for p in range(begin, end - 1):
        length, dx, dy = points[p, LENGTH], points[p, AHEAD_X], points[p, AHEAD_Y]
        relative_x, relative_y = x - points[p, X], y - points[p, Y]
        ahead = relative_x * dx + relative_y * dy
        # The first segment runs on backwards, the last one forwards.
        inside = ahead
        if p > begin:
            inside = max(inside, 0.0)
        if p < end - 2:
            inside = min(inside, length)
        apart_x, apart_y = relative_x - inside * dx, relative_y - inside * dy
        apart = apart_x * apart_x + apart_y * apart_y
        if apart < least:
            least = apart
            along, left = points[p, ALONG] + inside, dx * relative_y - dy * relative_x
    return along, left
