"""The road: lanelets, the area that they cover, and its edges."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import shapely

from avsec_gym.argument_checks import keep_checked, read_only, shown
from avsec_gym.errors import PlanningError
from avsec_gym.geometry import Floats
from avsec_gym.scenario.bounds import COORDINATE
from avsec_gym.scenario.shapes import points_as_tuples

_GAP = 0.01
"""Metres; narrower gaps between lanelets are drawing errors."""
_SLIT = 3e-10
"""Metres: narrower gaps between the sections of a road are no gaps."""


@dataclass(frozen=True)
class Lanelet:
    """A piece of lane between two bounds, in driving direction."""

    id: int
    left: tuple[tuple[float, float], ...]
    right: tuple[tuple[float, float], ...]
    predecessors: tuple[int, ...] = ()
    successors: tuple[int, ...] = ()
    adjacent_left: tuple[int, bool] | None = None
    """Id of the neighbour and whether it runs in the same direction."""
    adjacent_right: tuple[int, bool] | None = None
    types: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        COORDINATE.check_all(self.left, f"a point of the left bound of lanelet {self.id}")
        COORDINATE.check_all(self.right, f"a point of the right bound of lanelet {self.id}")
        # Lists and arrays are taken, and copied: what was checked stays what it is.
        what = f"a bound of lanelet {self.id}"
        for side in ("left", "right"):
            bound = points_as_tuples(getattr(self, side), what)
            if len(bound) < 2:
                raise PlanningError(
                    f"{what} is {shown(bound)}; expected two points (x, y) or more."
                )
            keep_checked(self, {side: bound})

    def polygon(self) -> shapely.Polygon:
        """The lanelet's area."""
        return shapely.Polygon([*self.left, *reversed(self.right)])


@dataclass(frozen=True)
class Road:
    """The lanelets; without any, the ground is free everywhere.

    The arrays that are worked out of them are read-only.
    """

    lanelets: tuple[Lanelet, ...] = ()

    def __post_init__(self) -> None:
        keep_checked(self, {"lanelets": tuple(self.lanelets)})

    def __setstate__(self, state: dict[str, Any]) -> None:
        # Arrays that come out of a pickle could be written into again.
        keep_checked(self, state)
        derived = state.get("edges"), state.get("closed_edges"), *state.get("centre_segments", ())
        for array in derived:
            if array is not None:
                read_only(array)

    @cached_property
    def area(self) -> shapely.Geometry:
        """Union of the road's sections, exactly as given: gaps between them stay gaps.

        A section is a lanelet with its neighbours; as in commonroad-drivability-checker only its
        outer bounds count, so that bounds between neighbours may be sampled differently.
        """
        sections = shapely.make_valid(np.array(_sections(self.lanelets), object))
        area = shapely.union_all(sections)
        if self.lanelets and not area.area > 0:
            raise PlanningError("the road has no area; correct the bounds of its lanelets.")
        if len(sections) == 1:
            return area
        # Close the slits that only rounding made.
        return area.buffer(_SLIT / 2, join_style="mitre").buffer(-_SLIT / 2, join_style="mitre")

    @cached_property
    def edges(self) -> Floats:
        """The road edge as segments x1, y1, x2, y2, shape (M, 4), collinear ones merged."""
        return read_only(_segments(self.area) if self.lanelets else np.zeros((0, 4)))

    @cached_property
    def closed_edges(self) -> Floats:
        """`edges` after gaps between lanelets of up to a centimetre are closed."""
        if not self.lanelets:
            return self.edges
        closed = self.area.buffer(_GAP / 2, join_style="mitre")
        closed = closed.buffer(-_GAP / 2, join_style="mitre")
        # Where nothing was closed, the exact edge is kept, free of rounding.
        same = abs(closed.area - self.area.area) < 1e-6 and _rings(closed) == _rings(self.area)
        return self.edges if same else read_only(_segments(closed))

    @cached_property
    def centre_segments(self) -> tuple[Floats, Floats]:
        """Starts and ends of the lanelets' centre lines, each of shape (S, 2)."""
        lines = [0.5 * (left + right) for left, right in map(_paired, self.lanelets)]
        if not lines:
            return read_only(np.zeros((0, 2))), read_only(np.zeros((0, 2)))
        starts, ends = [line[:-1] for line in lines], [line[1:] for line in lines]
        return read_only(np.vstack(starts)), read_only(np.vstack(ends))


def _paired(lanelet: Lanelet) -> tuple[Floats, Floats]:
    """Both bounds with as many points; the sparser one is walked at the pace of the other."""
    left, right = np.array(lanelet.left, float), np.array(lanelet.right, float)
    if len(left) < len(right):
        left = _at_the_pace_of(right, left)
    elif len(right) < len(left):
        right = _at_the_pace_of(left, right)
    return left, right


def _at_the_pace_of(dense: Floats, sparse: Floats) -> Floats:
    """Points of a line at the shares of its length at which another line has its points."""
    come = [np.r_[0.0, np.cumsum(np.hypot(*np.diff(line, axis=0).T))] for line in (dense, sparse)]
    at = come[0] / max(come[0][-1], 1e-12) * come[1][-1]
    return np.column_stack([np.interp(at, come[1], sparse[:, axis]) for axis in (0, 1)])


def _segments(area: shapely.Geometry) -> Floats:
    """The boundary of an area, shape (M, 4)."""
    boundary = shapely.boundary(shapely.simplify(area, 0.0))
    segments = []
    for line in shapely.get_parts(shapely.line_merge(boundary)):
        points = np.array(line.coords)
        segments.append(np.hstack([points[:-1], points[1:]]))
    return np.vstack(segments)


def _rings(area: shapely.Geometry) -> int:
    """Number of closed lines that bound an area."""
    return sum(1 + shapely.get_num_interior_rings(part) for part in shapely.get_parts(area))


def _sections(lanelets: tuple[Lanelet, ...]) -> list[shapely.Polygon]:
    """Areas of lanelets side by side, each from its rightmost to its leftmost bound."""
    known = {lanelet.id: lanelet for lanelet in lanelets}
    covered: set[int] = set()
    areas = []

    def walk(lanelet: Lanelet, forward: bool, to_the_left: bool) -> list[tuple[Lanelet, bool]]:
        """The lanelet and its neighbours on one side; forward: runs in the walk's direction."""
        row = [(lanelet, forward)]
        while True:
            neighbour = lanelet.adjacent_left if forward == to_the_left else lanelet.adjacent_right
            if neighbour is None or neighbour[0] not in known or len(row) > len(known):
                return row
            lanelet, forward = known[neighbour[0]], forward == neighbour[1]
            row.append((lanelet, forward))

    for lanelet in lanelets:
        if lanelet.id in covered:
            continue
        rightmost, forward = walk(lanelet, True, to_the_left=False)[-1]
        row = walk(rightmost, forward, to_the_left=True)
        covered.update(member.id for member, _ in row)
        bounds = [
            (member.right, member.left) if forward else (member.left[::-1], member.right[::-1])
            for member, forward in row
        ]
        starts = [point for right, left in bounds for point in (right[0], left[0])]
        ends = [point for right, left in reversed(bounds) for point in (left[-1], right[-1])]
        leftmost, rightmost_bound = bounds[-1][1], bounds[0][0]
        areas.append(shapely.Polygon([*starts, *leftmost[1:-1], *ends, *rightmost_bound[-2:0:-1]]))
    return areas


def straight_lanes(
    count: int, width: float = 3.5, start: float = -10.0, end: float = 130.0
) -> tuple[Lanelet, ...]:
    """Parallel straight lanes along x, centred on y = 0, numbered from right to left.

    Args:
        count: Number of lanes; odd, so that one is centred on the ego vehicle.
        width: Width of a lane, metres.
        start: Coordinate x at which the lanes begin, metres.
        end: Coordinate x at which they end, metres.
    """
    offsets: Sequence[float] = [(i - count / 2) * width for i in range(count + 1)]
    return tuple(
        Lanelet(
            id=i + 1,
            left=((start, offsets[i + 1]), (end, offsets[i + 1])),
            right=((start, offsets[i]), (end, offsets[i])),
            adjacent_left=(i + 2, True) if i + 1 < count else None,
            adjacent_right=(i, True) if i > 0 else None,
            types=("urban",),
        )
        for i in range(count)
    )
