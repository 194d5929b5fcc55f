"""highway-env's road network of a road of lanelets, straight and curved."""

from __future__ import annotations

from typing import Any

import numpy as np
from highway_env.road.lane import AbstractLane, LineType, StraightLane
from highway_env.road.road import RoadNetwork

from avsec_gym.closed_loop.centre_line import CentreLine
from avsec_gym.closed_loop.lanes import Lanes
from avsec_gym.closed_loop.road_frame import mirrored_points
from avsec_gym.geometry import Floats
from avsec_gym.scenario.road import Lanelet

LaneIndex = tuple[str, str, int]
_STRAIGHT = 1e-6
"""Metres by which the points of a straight lane may leave the line between its ends."""


class CurvedLane(AbstractLane):  # type: ignore[misc]
    """A lane along a line through points, in highway-env's plane.

    Args:
        points: x, y of the centre line in highway-env's plane, shape (n, 2), metres.
        width: Width of the lane, metres.
        line_types: highway-env's line types on the left and on the right.
        speed_limit: The speed limit, m/s.
    """

    def __init__(
        self,
        points: Any,
        width: float,
        line_types: tuple[int, int] = (LineType.STRIPED, LineType.STRIPED),
        speed_limit: float = 20.0,
    ) -> None:
        self.line = CentreLine(np.asarray(points, float))
        self.length, self.width, self.line_types = self.line.length, width, line_types
        self.speed_limit, self.forbidden, self.priority = speed_limit, False, 0

    def position(self, longitudinal: float, lateral: float) -> Floats:
        """The point at a distance along the lane and to its right, in highway-env's plane."""
        # The plane is mirrored: what the line calls left is highway-env's right.
        return np.array(self.line.place(longitudinal, lateral))

    def local_coordinates(self, position: Floats) -> tuple[float, float]:
        """The inverse of `position`."""
        return self.line.coordinates(float(position[0]), float(position[1]))

    def heading_at(self, longitudinal: float) -> float:
        """The lane's direction at a distance, radians."""
        return self.line.heading(longitudinal)

    def width_at(self, longitudinal: float) -> float:
        """The lane's width, metres."""
        return self.width

    @classmethod
    def from_config(cls, config: dict[str, Any]) -> CurvedLane:
        """The lane that `to_config` described."""
        return cls(**config)

    def to_config(self) -> dict[str, Any]:
        """A description of plain values."""
        return {
            "class_path": f"{type(self).__module__}.{type(self).__name__}",
            "config": {
                "points": self.line.points.tolist(),
                "width": self.width,
                "line_types": self.line_types,
                "speed_limit": self.speed_limit,
            },
        }


def network_of(lanes: Lanes, speed_limit: float = 20.0) -> RoadNetwork:
    """The road network of some lanes.

    Lanelets side by side in one direction become the lanes of one road, numbered from left to
    right as highway-env counts them; roads meet in a node where lanelets follow each other.

    Args:
        lanes: The lanes, in this project's plane.
        speed_limit: Speed limit of all lanes, m/s.
    """
    rows = _rows(lanes)
    row_of = {id: number for number, row in enumerate(rows) for id in row}
    # The end of a row and the start of every row that follows it are one node.
    node: dict[tuple[str, int], tuple[str, int]] = {}

    def root(end: tuple[str, int]) -> tuple[str, int]:
        while node.get(end, end) != end:
            end = node[end]
        return end

    for number, row in enumerate(rows):
        for id in row:
            for successor in lanes.by_id[id].successors:
                if successor in row_of:
                    node[root(("start", row_of[successor]))] = root(("end", number))
    network = RoadNetwork()
    for number, row in enumerate(rows):
        begin, end = (f"{side} {i}" for side, i in (root(("start", number)), root(("end", number))))
        for place, id in enumerate(row):
            edges = (
                LineType.CONTINUOUS if place == 0 else LineType.STRIPED,
                LineType.CONTINUOUS if place == len(row) - 1 else LineType.NONE,
            )
            network.add_lane(begin, end, _lane(lanes, id, edges, speed_limit))
    return network


def _rows(lanes: Lanes) -> list[list[int]]:
    """Ids of lanelets side by side in one direction, each row from left to right."""

    def beside(neighbour: tuple[int, bool] | None) -> int | None:
        known = neighbour is not None and neighbour[1] and neighbour[0] in lanes.by_id
        return neighbour[0] if known and neighbour is not None else None

    rows: list[list[int]] = []
    covered: set[int] = set()
    for lanelet in lanes.road.lanelets:
        if lanelet.id in covered:
            continue
        leftmost = _last(lanes, lanelet, lambda each: beside(each.adjacent_left))
        row, following = [leftmost], beside(lanes.by_id[leftmost].adjacent_right)
        while following is not None and following not in row:
            row.append(following)
            following = beside(lanes.by_id[following].adjacent_right)
        rows.append([id for id in row if id not in covered])
        covered.update(row)
    return rows


def _last(lanes: Lanes, lanelet: Lanelet, following: Any) -> int:
    """The last lanelet that one comes to; where they run in a circle, any of them."""
    passed = {lanelet.id}
    while (further := following(lanelet)) is not None and further not in passed:
        passed.add(further)
        lanelet = lanes.by_id[further]
    return lanelet.id


def _lane(lanes: Lanes, id: int, edges: tuple[int, int], speed_limit: float) -> AbstractLane:
    points = mirrored_points(lanes.own_lines[id].points)
    width = lanes.width(id)
    chord = CentreLine(points[[0, -1]])
    if all(abs(chord.coordinates(*point)[1]) < _STRAIGHT for point in points.tolist()):
        return StraightLane(points[0], points[-1], width, line_types=edges, speed_limit=speed_limit)
    return CurvedLane(points, width, edges, speed_limit)
