"""Lanelets as highway-env's lanes."""

from __future__ import annotations

import numpy as np
import pytest
from highway_env.road.lane import StraightLane, lane_from_config

from avsec_gym.closed_loop.lanes import Lanes
from avsec_gym.closed_loop.procedural_drives import road_of
from avsec_gym.closed_loop.road_network import CurvedLane, network_of
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.road import Lanelet, Road, straight_lanes
from avsec_gym.world.course import course_from_curvature
from avsec_gym.world.section import CrossSection, Lane, Strip, Surface

SECTION = CrossSection(
    (Strip(Surface.ROAD, -2.0, 9.0),),
    (),
    (Lane(0.0, 1, 10.0), Lane(3.5, 1, 10.0), Lane(7.0, -1, 10.0)),
)
BENT = Lanes(road_of(course_from_curvature(np.full(201, 0.01)), SECTION))


def test_straight_lanes_are_numbered_from_left_to_right() -> None:
    network = network_of(Lanes(Road(straight_lanes(3))))
    ((lanes,),) = [list(to.values()) for to in network.graph.values()]
    assert [type(lane) for lane in lanes] == [StraightLane] * 3
    # Left of the middle lies on the other side in highway-env's plane.
    assert [float(lane.start[1]) for lane in lanes] == [-3.5, 0.0, 3.5]


def test_a_bend_becomes_curved_lanes_and_oncoming_ones_a_road_of_their_own() -> None:
    network = network_of(BENT)
    roads = sorted(len(lanes) for to in network.graph.values() for lanes in to.values())
    assert roads == [1, 2]
    for lane in network.lanes_list():
        assert isinstance(lane, CurvedLane)
        for along, right in ((5.0, 1.0), (150.0, -0.7)):
            place = lane.position(along, right)
            np.testing.assert_allclose(lane.local_coordinates(place), (along, right), atol=0.02)


def test_a_lane_survives_its_configuration() -> None:
    lane = network_of(BENT).lanes_list()[0]
    again = lane_from_config(lane.to_config())
    np.testing.assert_array_equal(again.position(30.0, 1.0), lane.position(30.0, 1.0))


def test_intentions_lead_to_lanes_of_the_same_direction_only() -> None:
    right, left, oncoming = 1, 2, 3
    assert BENT.beside(right, Intention.LEFT) == left
    assert BENT.beside(left, Intention.LEFT) is None
    assert BENT.beside(right, Intention.RIGHT) is None
    assert BENT.intentions(oncoming) == (Intention.STRAIGHT,)


def test_a_car_is_in_the_lane_that_leads_its_way() -> None:
    x, y, heading = BENT.line(3).pose(60.0)
    assert BENT.at(x, y, heading) == 3
    assert BENT.at(x, y, heading + np.pi) == 2


def test_lanelets_that_follow_each_other_meet_in_a_node() -> None:
    def lanelet(id: int, start: float, successors: tuple[int, ...]) -> Lanelet:
        end = start + 50.0
        return Lanelet(id, ((start, 2.0), (end, 2.0)), ((start, -2.0), (end, -2.0)), (), successors)

    lanes = Lanes(Road((lanelet(1, 0.0, (2,)), lanelet(2, 50.0, ()))))
    network = network_of(lanes)
    first, second = network.lanes_dict()
    assert first[1] == second[0]
    assert lanes.line(1).length == pytest.approx(100.0)
