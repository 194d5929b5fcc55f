"""What lies beside what across a road: lanes, kerbs, pavements, verges, and the painted lines."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum, StrEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from avsec_gym.geometry import Floats


class Surface(IntEnum):
    """What a pixel shows: the classes of the world's masks."""

    SKY = 0
    ROAD = 1
    PARKING = 2
    CYCLE_PATH = 3
    PAVEMENT = 4
    KERB = 5
    VERGE = 6
    TERRAIN = 7
    BUILDING = 8
    VEGETATION = 9
    FURNITURE = 10
    VEHICLE = 11
    PERSON = 12


class LineKind(StrEnum):
    """How a line is painted."""

    SOLID = "solid"
    DASHED = "dashed"
    """3 m of paint, 6 m without (streets); 6 m and 12 m on highways."""
    DOUBLE = "double"


@dataclass(frozen=True)
class Strip:
    """A strip of ground along the road.

    Args:
        surface: Surface class of the strip.
        right: The right edge, metres to the left of the course (negative: right of it).
        left: The left edge.
        height: Height above the ground, metres; a pavement 0.12 behind its kerb.
        material: Kind of its surface: ``asphalt``, ``concrete``, ``cobbles``, ``slabs``,
            ``gravel``, ``grass``, ``soil``.
    """

    surface: Surface
    right: float
    left: float
    height: float = 0.0
    material: str = "asphalt"


@dataclass(frozen=True)
class Line:
    """A painted line: its middle, metres to the left of the course, and its width."""

    kind: LineKind
    left: float
    width: float = 0.12


@dataclass(frozen=True)
class Lane:
    """Where vehicles drive.

    Args:
        left: The middle, metres to the left of the course.
        direction: Direction of travel: 1 along the course, -1 against it.
        speed: Usual speed, m/s.
        width: Width of the lane, metres.
    """

    left: float
    direction: int
    speed: float
    width: float = 3.5


@dataclass(frozen=True)
class CrossSection:
    """A road from right to left.

    Args:
        strips: Strips without gaps, from right to left; beyond the outermost ones lies open
            terrain.
        lines: Painted lines.
        lanes: Lanes from right to left.
    """

    strips: tuple[Strip, ...]
    lines: tuple[Line, ...]
    lanes: tuple[Lane, ...]

    @property
    def edges(self) -> tuple[float, float]:
        """Right and left end of the outermost strips."""
        return self.strips[0].right, self.strips[-1].left

    @property
    def carriageway(self) -> tuple[float, float]:
        """Right and left edge of what is driven on."""
        road = [strip for strip in self.strips if strip.surface == Surface.ROAD]
        return road[0].right, road[-1].left

    def height(self, left: ArrayLike) -> Floats:
        """Height above the ground at places across the road; 0 beyond the edges."""
        heights = np.array([0.0, *(strip.height for strip in self.strips), 0.0])
        return np.asarray(heights[self._place(left)])

    def surface(self, left: ArrayLike) -> NDArray[np.int64]:
        """`Surface` at places across the road; TERRAIN beyond the edges."""
        kinds = [strip.surface for strip in self.strips]
        return np.array([Surface.TERRAIN, *kinds, Surface.TERRAIN])[self._place(left)]

    def _place(self, left: ArrayLike) -> NDArray[np.int64]:
        borders = [strip.right for strip in self.strips] + [self.strips[-1].left]
        return np.asarray(np.searchsorted(borders, np.asarray(left, float), side="right"))
