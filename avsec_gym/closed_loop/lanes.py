"""What a driver knows of a road: which lane it is in, which lie beside it, and where they lead."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import shapely

from avsec_gym.closed_loop.centre_line import CentreLine
from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats, wrap_angle
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.road import Lanelet, Road

_HEADING_WEIGHT = 4.0
"""Metres that a radian between a vehicle and a lane counts for, in the choice of its lane."""
_ALONG = 0.5
"""Radians between a vehicle and its lane, up to which it drives in the lane."""
_SEAM = 0.01
"""Metres by which lanes are widened, so that rounding opens no gap."""


@dataclass(frozen=True, eq=False)
class Lanes:
    """The lanes of a road, each with the line that it leads along.

    Args:
        road: The lanelets.

    Raises:
        ConfigurationError: There are none.
    """

    road: Road
    _lines: dict[tuple[int, bool], CentreLine] = field(default_factory=dict, repr=False)
    _widths: dict[int, float] = field(default_factory=dict, repr=False)

    def __post_init__(self) -> None:
        if not self.road.lanelets:
            raise ConfigurationError("a road to drive on has lanelets, this one has none")

    @cached_property
    def by_id(self) -> dict[int, Lanelet]:
        """The lanelets."""
        return {lanelet.id: lanelet for lanelet in self.road.lanelets}

    @cached_property
    def bend(self) -> bool:
        """Whether some lane is more than one straight stretch."""
        return any(len(self.line(lanelet.id).points) > 2 for lanelet in self.road.lanelets)

    def line(self, id: int, *, through_forks: bool = True) -> CentreLine:
        """The centre line from the start of a lanelet on, through the first of its successors.

        Args:
            id: The id of the lanelet.
            through_forks: Whether it goes on where there are several successors; if not, it ends
                there, and is straight from there on.
        """
        if (id, through_forks) not in self._lines:
            points: list[Floats] = []
            passed: set[int] = set()
            following: int | None = id
            while following is not None and following not in passed and following in self.by_id:
                passed.add(following)
                points.append(centre_points(self.by_id[following]))
                successors = self.by_id[following].successors
                known = len(successors) == 1 or (through_forks and bool(successors))
                following = successors[0] if known else None
            self._lines[id, through_forks] = CentreLine(_without_repeats(np.vstack(points)))
        return self._lines[id, through_forks]

    def width(self, id: int) -> float:
        """Mean width of a lanelet, metres."""
        if id not in self._widths:
            lanelet = self.by_id[id]
            apart = np.asarray(lanelet.left, float) - np.asarray(lanelet.right, float)
            self._widths[id] = float(np.hypot(*apart.T).mean())
        return self._widths[id]

    def at(self, x: float, y: float, heading: float) -> int:
        """The id of the lanelet that a vehicle drives in: the nearest that leads its way."""

        def distance(lanelet: Lanelet) -> float:
            line = self.own_lines[lanelet.id]
            along, left = line.coordinates(x, y)
            beyond = max(-along, along - line.length, 0.0)
            turned = abs(float(wrap_angle(heading - line.heading(along))))
            return abs(left) + beyond + _HEADING_WEIGHT * turned

        return min(self.road.lanelets, key=distance).id

    def followed(self, x: float, y: float, heading: float) -> int | None:
        """The id of the lanelet that a vehicle follows; None: it crosses its lane, or has none."""
        lane = self.at(x, y, heading)
        line = self.line(lane)
        along, left = line.coordinates(x, y)
        turned = float(wrap_angle(heading - line.heading(along)))
        return lane if abs(turned) < _ALONG and abs(left) < 0.5 * self.width(lane) else None

    def beside(self, id: int, intention: Intention) -> int | None:
        """The lanelet that an intention leads to; None: none of the same direction is there."""
        if intention == Intention.STRAIGHT:
            return id
        lanelet = self.by_id[id]
        neighbour = lanelet.adjacent_left if intention == Intention.LEFT else lanelet.adjacent_right
        if neighbour is None or not neighbour[1] or neighbour[0] not in self.by_id:
            return None
        return neighbour[0]

    def intentions(self, id: int) -> tuple[Intention, ...]:
        """The intentions that lead from a lanelet to one of the same direction."""
        return tuple(each for each in Intention if self.beside(id, each) is not None)

    @cached_property
    def areas(self) -> tuple[shapely.Geometry, ...]:
        """The area of each lane along its whole line, prepared for many questions."""
        areas = []
        for lanelet in self.road.lanelets:
            # Lanelets that follow each other are one lane: a car on their seam is in one.
            parts = [lanelet, *(self.by_id[id] for id in lanelet.successors if id in self.by_id)]
            area = shapely.union_all([part.polygon().buffer(_SEAM) for part in parts])
            shapely.prepare(area)
            areas.append(area)
        return tuple(areas)

    @cached_property
    def drivable(self) -> shapely.Geometry:
        """The area that may be driven on, prepared for many questions."""
        area = self.road.area.buffer(_SEAM)
        shapely.prepare(area)
        return area

    @cached_property
    def own_lines(self) -> dict[int, CentreLine]:
        """The centre line of each lanelet alone."""
        return {lanelet.id: CentreLine(centre_points(lanelet)) for lanelet in self.road.lanelets}


def centre_points(lanelet: Lanelet) -> Floats:
    """Points between the bounds of a lanelet, shape (n, 2).

    Bounds of different numbers of points are sampled anew, evenly along each.
    """
    left, right = np.asarray(lanelet.left, float), np.asarray(lanelet.right, float)
    if len(left) != len(right):
        count = max(len(left), len(right))
        left, right = _sampled(left, count), _sampled(right, count)
    return _without_repeats(0.5 * (left + right))


def _sampled(points: Floats, count: int) -> Floats:
    line = CentreLine(_without_repeats(points))
    return np.array([line.place(along) for along in np.linspace(0.0, line.length, count)])


def _without_repeats(points: Floats) -> Floats:
    apart = np.hypot(*np.diff(points, axis=0).T)
    return points[np.concatenate([[True], apart > 1e-6])]
