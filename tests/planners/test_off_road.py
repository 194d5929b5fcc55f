"""The planner's answers about roads: off it, narrow gaps in it, and a start that is taken."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import PlanningError
from avsec_gym.planners.plan import Reason, Status
from avsec_gym.planners.planner import Mode, MotionPrimitivePlanner
from avsec_gym.planners.primitives import MotionPrimitives, generate_primitives
from avsec_gym.scenario.builder import build_planning_scenario
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.planning_scenario import EgoState, PlanningScenario
from avsec_gym.scenario.road import Lanelet, Road
from avsec_gym.scenario.shapes import Rectangle


@pytest.fixture
def straight_on() -> PlanningScenario:
    return build_planning_scenario(Boxes3D.empty())


def test_a_goal_beside_the_road(straight_on: PlanningScenario) -> None:
    beside = replace(straight_on.goals[0], region=(Rectangle(5.0, 3.5, 15.0, 100.0),))
    plan = MotionPrimitivePlanner().plan(replace(straight_on, goals=(beside,)))
    assert plan.reason == Reason.OFF_ROAD
    assert "road" in plan.explanation


def test_a_start_beside_the_road(straight_on: PlanningScenario) -> None:
    away = replace(straight_on, start=replace(straight_on.start, y=60.0))
    assert MotionPrimitivePlanner().plan(away).reason == Reason.OFF_ROAD


def test_a_goal_out_of_reach_may_be_occupied_all_the_same(straight_on: PlanningScenario) -> None:
    far = replace(straight_on.goals[0], region=(Rectangle(5.0, 3.5, 100.0, 0.0),))
    block = Obstacles.rectangles(np.array([[100.0, 0, 0]]), np.array([30.0]), np.array([30.0]))
    plan = MotionPrimitivePlanner().plan(replace(straight_on, goals=(far,), obstacles=block))
    assert plan.reason == Reason.GOAL_OCCUPIED


@pytest.mark.parametrize(
    ("ahead", "beside", "reason"),
    [
        (4.0, 1.5, Reason.UNREACHABLE),
        (2.0, 1.5, Reason.START_OCCUPIED),
        (4.0, 1.0, Reason.START_OCCUPIED),
    ],
)
def test_the_start_is_occupied_by_what_the_vehicle_touches(
    straight_on: PlanningScenario, ahead: float, beside: float, reason: Reason
) -> None:
    """A wall ahead of a car 4.5 m long, and one beside it, which is 1.6 m wide."""
    walls = Obstacles.rectangles(
        np.array([[ahead, 0, 0], [0, beside, 0]]), np.array([0.1, 4.0]), np.array([60.0, 0.6])
    )
    plan = MotionPrimitivePlanner().plan(straight_on.with_obstacles(walls))
    assert (plan.found, plan.reason) == (False, reason)


def test_no_plan_starts_inside_an_object(straight_on: PlanningScenario) -> None:
    """Also where the object drives off at once."""
    leaving = Obstacles.rectangles(
        np.array([[0.0, 0.0, np.pi / 2]]), np.array([1.0]), np.array([1.0]), np.array([60.0]),
        last_step=30,
    )  # fmt: skip
    for keep_tree in (False, True):
        planner = MotionPrimitivePlanner(keep_tree=keep_tree)
        plan = planner.plan(straight_on.with_obstacles(leaving))
        assert (plan.status, plan.reason) == (Status.EXHAUSTED, Reason.START_OCCUPIED)


@pytest.mark.parametrize(("gap", "found"), [(0.0, True), (1e-9, True), (5e-3, True), (0.05, False)])
def test_gaps_between_lanelets(straight_on: PlanningScenario, gap: float, found: bool) -> None:
    def lanelet(id: int, start: float, end: float) -> Lanelet:
        return Lanelet(id, ((start, 1.75), (end, 1.75)), ((start, -1.75), (end, -1.75)))

    road = Road((lanelet(1, -10.0, 8.0), lanelet(2, 8.0 + gap, 60.0)))
    plan = MotionPrimitivePlanner().plan(replace(straight_on, road=road))
    assert plan.found == found
    # commonroad-search's road is exact.
    reference = MotionPrimitivePlanner(mode=Mode.REFERENCE, node_limit=500)
    assert reference.plan(replace(straight_on, road=road)).found == (gap == 0.0)


def test_the_start_speed_is_told(straight_on: PlanningScenario) -> None:
    assert MotionPrimitivePlanner().plan(straight_on).start_speed == 6.0


@pytest.mark.parametrize("primitives", [None, generate_primitives((6.0, 8.0))])
@pytest.mark.parametrize("mode", list(Mode))
def test_speeds_far_from_all_primitives_are_refused(
    straight_on: PlanningScenario, primitives: MotionPrimitives | None, mode: Mode
) -> None:
    planner = MotionPrimitivePlanner(mode=mode, primitives=primitives)
    for velocity in (-6.0, -0.2, 70.0, 1000.0):
        start = EgoState(velocity=velocity)
        with pytest.raises(PlanningError, match=rf"velocity is {velocity:g} m/s; expected 0 to"):
            planner.plan(replace(straight_on, start=start))
    # The thesis' scenarios say 0 m/s; recordings of standing vehicles are noisy.
    for velocity in (-0.05, 0.0, 15.0):
        planner.plan(replace(straight_on, start=EgoState(velocity=velocity)))
