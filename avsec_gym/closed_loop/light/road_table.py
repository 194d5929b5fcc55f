"""A scene's road as a table that kernels read: centre lines, widths, and the drivable area."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from avsec_gym.closed_loop.angles import wrapped
from avsec_gym.closed_loop.centre_line import (
    AHEAD_X,
    AHEAD_Y,
    ALONG,
    HEADING,
    X,
    Y,
    coordinates,
)
from avsec_gym.closed_loop.lanes import Lanes
from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel

_HEADING_WEIGHT = 4.0
"""Metres that a radian between a vehicle and a lane counts for, as in `Lanes.at`."""


class RoadTable(NamedTuple):
    """L lanelets, in the order of the road."""

    points: Floats
    """Points of lines, one line after the other, as `coordinates` reads them, shape (P, 7)."""
    lines: NDArray[np.int64]
    """First point and the one after the last, of each lanelet's line through its successors,
    shape (L, 2)."""
    own: NDArray[np.int64]
    """The same of each lanelet's own centre line."""
    widths: Floats
    """Their widths, metres, shape (L,)."""
    edges: Floats
    """Edges of the drivable area, from x, y to x, y, shape (E, 4)."""


@lru_cache(maxsize=16)
def road_table(lanes: Lanes) -> RoadTable:
    """The lanes of a road, laid out once for all scenes on it."""
    ids = [lanelet.id for lanelet in lanes.road.lanelets]
    rows: list[Floats] = []
    spans: list[tuple[int, int]] = []
    begin = 0
    for line in [*(lanes.line(id) for id in ids), *(lanes.own_lines[id] for id in ids)]:
        rows.append(line.table)
        spans.append((begin, begin + len(rows[-1])))
        begin += len(rows[-1])
    return RoadTable(
        points=np.concatenate(rows),
        lines=np.array(spans[: len(ids)], np.int64),
        own=np.array(spans[len(ids) :], np.int64),
        widths=np.array([lanes.width(id) for id in ids]),
        edges=_edges(lanes.drivable),
    )


def _edges(area: shapely.Geometry) -> Floats:
    rings = shapely.get_rings(shapely.get_parts(area))
    corners = [shapely.get_coordinates(ring) for ring in rings]
    return np.concatenate([np.hstack([ring[:-1], ring[1:]]) for ring in corners])


@kernel(nogil=True)
def contains(edges: Floats, x: float, y: float) -> bool:
    """Whether a point lies in an area: a ray from it crosses an odd number of edges."""
    inside = False
    for e in range(len(edges)):
        ax, ay, bx, by = edges[e, 0], edges[e, 1], edges[e, 2], edges[e, 3]
        if (ay > y) != (by > y) and x < ax + (y - ay) / (by - ay) * (bx - ax):
            inside = not inside
    return inside


@kernel(nogil=True)
def heading_at(points: Floats, begin: int, end: int, along: float) -> float:
    """`CentreLine.heading`: linear between points, constant beyond the ends; may be off by 2 pi."""
    p = _segment(points, begin, end, along)
    low, high = points[p, ALONG], points[p + 1, ALONG]
    share = min(max((along - low) / (high - low), 0.0), 1.0)
    return float(points[p, HEADING] + share * (points[p + 1, HEADING] - points[p, HEADING]))


@kernel(nogil=True)
def place_at(points: Floats, begin: int, end: int, along: float) -> tuple[float, float]:
    """`CentreLine.place` on the line: x, y."""
    p = _segment(points, begin, end, along)
    ahead = along - points[p, ALONG]
    return points[p, X] + ahead * points[p, AHEAD_X], points[p, Y] + ahead * points[p, AHEAD_Y]


@kernel(nogil=True)
def lane_at(road: RoadTable, x: float, y: float, heading: float) -> int:
    """`Lanes.at`: the row of the lanelet that a vehicle drives in."""
    nearest, least = 0, np.inf
    for lane in range(len(road.own)):
        begin, end = road.own[lane, 0], road.own[lane, 1]
        along, left = coordinates(road.points, begin, end, x, y)
        beyond = max(-along, along - road.points[end - 1, ALONG], 0.0)
        turned = abs(wrapped(heading - heading_at(road.points, begin, end, along)))
        distance = abs(left) + beyond + _HEADING_WEIGHT * turned
        if distance < least:
            nearest, least = lane, distance
    return nearest


@kernel(nogil=True)
def _segment(points: Floats, begin: int, end: int, along: float) -> int:
    """The last segment that begins at or before a distance, the first one at least."""
    low, high = begin, end - 2
    while low < high:
        middle = (low + high + 1) // 2
        if points[middle, ALONG] <= along:
            low = middle
        else:
            high = middle - 1
    return low
