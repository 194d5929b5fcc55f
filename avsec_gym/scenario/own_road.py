"""The road that a procedural scene lies on, as its car sees it, for the thesis' straight lanes.

A layout has a road of its own: it turns away from the car a little, bends, and has as many lanes as
its objects need.  The thesis' car drives on 27 straight lanes instead.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.rig import kitti_rig
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.lanes_across import LaneAcross, lanes_along, neighbour_of
from avsec_gym.scenario.road import Road
from avsec_gym.scenario.shapes import Rectangle
from avsec_gym.world.course import Course, course_from_curvature
from avsec_gym.world.layouts import SceneLayout

_BEHIND, _AHEAD = -30.0, 90.0
"""Metres of road behind and ahead of the car, over which a layout's road bends evenly."""
_SPACING = 4.0
"""Metres between the points of lanes: at the sharpest bends, 3 cm from the arc."""
_LANE_WIDTH = 3.5
"""The largest width of a lane, as the world is built around layouts."""
_MEDIAN = 2.1
"""Metres between a lane and an oncoming one from which on the world builds a median there."""


@dataclass(frozen=True, eq=False)
class OwnRoad:
    """The road of one scene in the ego frame: the car stands at 0 along it, heading along x.

    The road is its lanes: hard shoulders and what lies beside the carriageway are not driven on.

    Args:
        course: Where it runs.
        lanes: Its lanes from right to left; one of them leads the car's way at 0.
    """

    course: Course
    lanes: tuple[LaneAcross, ...]

    @cached_property
    def road(self) -> Road:
        """The lanelets."""
        along = np.arange(_BEHIND, _AHEAD + 0.5 * _SPACING, _SPACING)

        def points(left: float) -> Floats:
            return self.course.poses(along, np.full(len(along), left))[:, :2]

        return Road(lanes_along(points, self.lanes))

    @property
    def intentions(self) -> tuple[Intention, ...]:
        """The intentions that lead to a lane of the car's own direction."""
        return tuple(each for each in Intention if self._lane(each) is not None)

    def stretch(self, intention: Intention, ahead: float, length: float) -> Rectangle:
        """A stretch of the lane that an intention leads to, as wide as the lane.

        Args:
            intention: One of `intentions`.
            ahead: Metres along the road from the car to the stretch's middle.
            length: Length of the stretch, metres.
        """
        lane = self._lane(intention)
        assert lane is not None
        x, y, heading = self.course.poses(ahead, lane.middle).tolist()
        return Rectangle(length, lane.width, x, y, heading)

    def _lane(self, intention: Intention) -> LaneAcross | None:
        """The lane that an intention leads to; None: none of the car's direction is there."""
        ways = [number for number, lane in enumerate(self.lanes) if lane.direction > 0]
        number: int | None = min(ways, key=lambda each: abs(self.lanes[each].middle))
        assert number is not None
        if step := Intention(intention).lanes_to_the_left:
            number = neighbour_of(self.lanes, number, step)
        if number is None or self.lanes[number].direction < 0:
            return None
        return self.lanes[number]


def own_road_of(layout: SceneLayout) -> OwnRoad:
    """The road that the world builds for a layout.

    Args:
        layout: The layout.
    """
    # Most scenes ask for no road, and to import this takes long.
    from avsec_gym.world.framing import actors_from_boxes, highway_lanes
    from avsec_gym.world.road.sections import section_for_lanes
    from avsec_gym.world.site import Style

    count = round((_AHEAD - _BEHIND) / _SPACING) + 1
    course = course_from_curvature(
        np.full(count, layout.road.curvature),
        start=_BEHIND,
        spacing=_SPACING,
        pose=(0.0, 0.0, layout.road.heading),
    )
    # Only looks and roadsides are drawn, which change no lane.
    rng = np.random.default_rng(0)
    style, offsets = Style.RESIDENTIAL, layout.road.lane_offsets
    if layout.road_type == RoadType.HIGHWAY:
        still = np.zeros(len(layout.boxes))
        style = Style.HIGHWAY
        offsets = highway_lanes(
            actors_from_boxes(layout.boxes, kitti_rig(), still, rng), course, offsets
        )
    lanes = section_for_lanes(offsets, _LANE_WIDTH, style, rng).lanes
    bounds = [[lane.left - 0.5 * lane.width, lane.left + 0.5 * lane.width] for lane in lanes]
    # Two lanes without a median between them meet halfway.
    for number, (right, left) in enumerate(pairwise(bounds)):
        same_way = lanes[number].direction == lanes[number + 1].direction
        if same_way or left[0] - right[1] < _MEDIAN:
            right[1] = left[0] = 0.5 * (right[1] + left[0])
    return OwnRoad(
        course,
        tuple(
            LaneAcross(right, left, lane.direction)
            for (right, left), lane in zip(bounds, lanes, strict=True)
        ),
    )
