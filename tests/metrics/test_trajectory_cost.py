"""Costs by hand, and SM1's terms against CommonRoad's own functions."""

from __future__ import annotations

import enum
import importlib
import sys
import types
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import simpson

from avsec_gym.boxes import Boxes3D
from avsec_gym.metrics.trajectory_cost import (
    lane_heading,
    path_length,
    simpson_weights,
    sm1_cost,
    travel_time,
)
from avsec_gym.planners.planner import MotionPrimitivePlanner
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.builder import build_planning_scenario
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.planning_scenario import EgoState, Goal, PlanningScenario
from avsec_gym.scenario.road import Lanelet, Road


def straight(speed: float, steps: int = 20) -> np.ndarray:
    states = np.zeros((steps + 1, 5))
    states[:, 0], states[:, 2] = 0.1 * speed * np.arange(steps + 1), speed
    return states


def problem(*goals: Goal, road: Road | None = None) -> PlanningScenario:
    return PlanningScenario("a", EgoState(), goals or (Goal((4, 30)),), road=road or Road())


def test_lengths_and_times() -> None:
    assert path_length(straight(8.0)) == pytest.approx(16.0)
    assert travel_time(straight(8.0), 0.1) == pytest.approx(2.0)
    corner = np.array([[0, 0, 0, 0, 0], [3.0, 0, 0, 0, 0], [3.0, 4.0, 0, 0, 0]])
    assert path_length(corner) == 7.0
    assert (path_length(corner[:1]), travel_time(corner[:1], 0.1)) == (0.0, 0.0)


def test_sm1_of_a_straight_drive_by_hand() -> None:
    """8 m/s for 2 s, 2 m/s above the goal's lowest speed: 16 m + 20 * 2^2 * 2 s."""
    goal = Goal((4, 30), velocity=(6.0, 8.0))
    assert sm1_cost(straight(8.0), problem(goal)) == pytest.approx(16.0 + 20 * 4 * 2.0)
    assert sm1_cost(straight(8.0), problem()) == pytest.approx(16.0)


def test_sm1_of_braking_and_of_driving_askew() -> None:
    braking = straight(8.0)
    braking[:, 2] = 8.0 - 2.0 * 0.1 * np.arange(21)
    # Simpson over 20 accelerations of -2 m/s2: 1.9 s; the length is the integral of the speed.
    assert sm1_cost(braking, problem()) == pytest.approx(50 * 4 * 1.9 + 12.0)
    askew = straight(8.0)
    askew[:, 3] = 0.2
    assert sm1_cost(askew, problem()) == pytest.approx(16.0 + 50 * 0.04 * 2.0)


@pytest.fixture(scope="module")
def theirs() -> Any:
    """commonroad-drivability-checker's functions; its route matcher's package is not needed."""
    pytest.importorskip("commonroad_dc")
    stub = types.ModuleType("commonroad_dc.costs.route_matcher")
    stub.SolutionProperties = enum.Enum("SolutionProperties", ["NONE"])  # type: ignore[attr-defined]
    name = "commonroad_dc.costs.partial_cost_functions"
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, stub.__name__, stub)
        patch.delitem(sys.modules, name, raising=False)
        return importlib.import_module(name)


@pytest.mark.parametrize("road_type", list(RoadType))
@pytest.mark.parametrize("intention", list(Intention))
def test_sm1_is_commonroads(theirs: Any, road_type: RoadType, intention: Intention) -> None:
    ours = build_planning_scenario(Boxes3D.empty(), road_type=road_type, intention=intention)
    trajectory = MotionPrimitivePlanner().plan(ours).trajectory
    assert trajectory is not None
    wanted = SimpleNamespace(velocity=ours.goals[0].velocity[0])  # type: ignore[index]
    states = [
        # The lanes run along x, so the heading is the angle to the lane.
        SimpleNamespace(velocity=v, steering_angle=steering, delta_orientation=heading)
        for _, _, v, heading, steering in trajectory
    ]
    arguments = (
        SimpleNamespace(dt=0.1),
        SimpleNamespace(goal=SimpleNamespace(state_list=[wanted])),
        SimpleNamespace(state_list=states),
        {},
    )
    expected = (
        50 * theirs.acceleration_cost(*arguments)
        + 50 * theirs.steering_angle_cost(*arguments)
        + 50 * theirs.steering_rate_cost(*arguments)
        + 1 * theirs.path_length_cost(*arguments)
        + 20 * theirs.velocity_offset_cost(*arguments)
        + 50 * theirs.orientation_offset_cost(*arguments)
    )
    assert sm1_cost(trajectory, ours) == pytest.approx(expected, rel=1e-12)


def test_the_nearest_lane_gives_the_direction() -> None:
    east = Lanelet(1, ((0.0, 1.0), (10.0, 1.0)), ((0.0, -1.0), (10.0, -1.0)))
    north = Lanelet(2, ((19.0, 0.0), (19.0, 10.0)), ((21.0, 0.0), (21.0, 10.0)))
    headings = lane_heading(np.array([[2.0, 0.5], [19.5, 4.0]]), Road((east, north)))
    np.testing.assert_allclose(headings, [0.0, np.pi / 2])
    np.testing.assert_allclose(lane_heading(np.ones((3, 2)), Road()), 0.0)


def test_a_lane_to_the_west_does_not_break_the_angle() -> None:
    west = Lanelet(1, ((10.0, -1.0), (0.0, -1.0)), ((10.0, 1.0), (0.0, 1.0)))
    back = straight(8.0)
    back[:, 0], back[:, 3] = 8.0 - back[:, 0], -np.pi + 0.1
    expected = 16.0 + 50 * 0.1**2 * 2.0
    assert sm1_cost(back, problem(road=Road((west,)))) == pytest.approx(expected)


@pytest.mark.parametrize("count", [*range(1, 12), 30, 31])
def test_simpsons_weights_are_scipys(count: int) -> None:
    values = np.random.default_rng(count).normal(size=count)
    expected = simpson(values, dx=0.1) if count > 1 else 0.0
    assert values @ simpson_weights(count, 0.1) == pytest.approx(expected, abs=1e-12)
