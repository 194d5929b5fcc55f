"""A road where there is no map: three lanes along the recorded car's own path."""

from __future__ import annotations

import numpy as np

from avsec_gym.closed_loop.centre_line import CentreLine
from avsec_gym.geometry import Floats
from avsec_gym.scenario.builder import LANE_WIDTH
from avsec_gym.scenario.road import Lanelet, Road

OWN, LEFT, RIGHT = 1, 2, 3
"""Ids of the lanes."""
_SPACING = 2.0
"""Metres between points of a lane."""
_BEHIND, _BEYOND = 60.0, 240.0
"""Metres of straight road before the path and beyond it."""
_SMOOTHED = 8.0
"""Metres over which the path's direction is averaged."""


def corridor(path: Floats, *, against: frozenset[int] = frozenset()) -> Road:
    """Three lanes of 3.5 m: the middle one along a path, one on each of its sides.

    Args:
        path: x, y of the car over time, shape (n, 2); the road runs on straight before and after.
        against: Lanes that lead against the path.
    """
    line = centre_of(path)
    headings = np.array([line.heading(along) for along in line.along])
    normal = np.column_stack([-np.sin(headings), np.cos(headings)])

    def bound(left: float) -> tuple[tuple[float, float], ...]:
        x_y = (line.points + left * normal).tolist()
        return tuple((float(x), float(y)) for x, y in x_y)

    half = 0.5 * LANE_WIDTH
    sides = {OWN: (half, -half), LEFT: (3 * half, half), RIGHT: (-half, -3 * half)}
    lanelets = []
    for lane, (left, right) in sides.items():
        turned = lane in against
        beside = {
            OWN: ((LEFT, LEFT not in against), (RIGHT, RIGHT not in against)),
            LEFT: (None, (OWN, LEFT not in against)),
            RIGHT: ((OWN, RIGHT not in against), None),
        }[lane]
        lanelets.append(
            Lanelet(
                id=lane,
                left=bound(right)[::-1] if turned else bound(left),
                right=bound(left)[::-1] if turned else bound(right),
                adjacent_left=beside[1] if turned else beside[0],
                adjacent_right=beside[0] if turned else beside[1],
            )
        )
    return Road(tuple(lanelets))


def centre_of(path: Floats) -> CentreLine:
    """The line along a path, evenly sampled, smooth, and straight beyond both ends.

    Args:
        path: x, y of the car over time, shape (n, 2).
    """
    kept = [0]
    for row in range(1, len(path)):
        if np.hypot(*(path[row] - path[kept[-1]])) >= 0.5 * _SPACING:
            kept.append(row)
    points = path[kept] if len(kept) > 1 else np.array([path[0], path[0] + (_SPACING, 0.0)])
    rough = CentreLine(points)
    along = np.arange(-_BEHIND, rough.length + _BEYOND, _SPACING)
    even = np.array([rough.place(float(each)) for each in along])
    # Averages along the line, the ends padded with its own straight ends.
    reach = round(0.5 * _SMOOTHED / _SPACING)
    weights = np.ones(2 * reach + 1) / (2 * reach + 1)
    smooth = np.column_stack([np.convolve(column, weights, "valid") for column in even.T])
    return CentreLine(smooth)
