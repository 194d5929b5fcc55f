"""Lanelets side by side along a line, from what lies across the road."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from avsec_gym.geometry import Floats
from avsec_gym.scenario.road import Lanelet

_APART = 0.05
"""Metres between the bounds of two lanes from which on they are no neighbours."""


@dataclass(frozen=True)
class LaneAcross:
    """A lane of a road, as it lies across it.

    Args:
        right: Its right bound, metres to the left of the road's line.
        left: Its left bound.
        direction: Direction of travel: 1 along the line, -1 against it.
    """

    right: float
    left: float
    direction: int

    @property
    def middle(self) -> float:
        """Halfway between the bounds, metres to the left of the road's line."""
        return 0.5 * (self.right + self.left)

    @property
    def width(self) -> float:
        """Metres."""
        return self.left - self.right


def neighbour_of(lanes: Sequence[LaneAcross], number: int, step: int) -> int | None:
    """The number of the lane beside a lane; None: none, or one across a median.

    Args:
        lanes: The road's lanes, from right to left.
        number: The number of the lane.
        step: The direction: 1 to the left of the road's line, -1 to its right.
    """
    other = number + step
    if not 0 <= other < len(lanes):
        return None
    low, high = sorted((number, other))
    return other if lanes[high].right - lanes[low].left <= _APART else None


def lanes_along(
    points: Callable[[float], Floats], lanes: Sequence[LaneAcross]
) -> tuple[Lanelet, ...]:
    """The lanes of a road, each one lanelet in its direction, numbered from right to left.

    Args:
        points: Points x, y of the line so many metres to the left of the road's, shape (N, 2),
            metres.
        lanes: The road's lanes, from right to left.
    """
    lanelets = []
    for number, lane in enumerate(lanes):
        low, high = (
            tuple((float(x), float(y)) for x, y in points(bound))
            for bound in (lane.right, lane.left)
        )
        right, left = (low, high) if lane.direction > 0 else (high[::-1], low[::-1])
        lanelets.append(
            Lanelet(
                id=number + 1,
                left=left,
                right=right,
                adjacent_left=_adjacent(lanes, number, lane.direction),
                adjacent_right=_adjacent(lanes, number, -lane.direction),
            )
        )
    return tuple(lanelets)


def _adjacent(lanes: Sequence[LaneAcross], number: int, step: int) -> tuple[int, bool] | None:
    """The id of the lanelet beside one, and whether it runs the same way."""
    other = neighbour_of(lanes, number, step)
    if other is None:
        return None
    return other + 1, lanes[other].direction == lanes[number].direction
