"""A car that brakes at a stops after v^2 / 2a, and hits what stands nearer."""

from __future__ import annotations

import math

import numpy as np
import pytest

from avsec_gym.emergency_stop import DECELERATION, STOPPED, emergency_stop, judge_stop
from avsec_gym.planners.vehicle import BMW_320I
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.planning_scenario import EgoState, PlanningScenario


def problem(velocity: float, heading: float = 0.0) -> PlanningScenario:
    return PlanningScenario("1", EgoState(2.0, -1.0, velocity, heading), ())


@pytest.mark.parametrize("velocity", [0.0, 0.4, 6.0, 11.0, 13.37])
@pytest.mark.parametrize("heading", [0.0, 0.3])
def test_braking_distance(velocity: float, heading: float) -> None:
    states = emergency_stop(problem(velocity, heading)).trajectory
    assert states is not None
    driven = np.hypot(*(states[:, :2] - states[0, :2]).T)
    assert driven[-1] == pytest.approx(velocity**2 / (2 * DECELERATION))
    assert (states[0, 2], states[-1, 2]) == pytest.approx((velocity, 0.0))
    assert states[:, 3] == pytest.approx(heading)
    along = states[-1, :2] - states[0, :2]
    assert np.arctan2(along[1], along[0]) == pytest.approx(heading if velocity else 0.0)
    # Speeds and places belong together, step by step.
    steps, mean_speed = np.diff(driven), (states[1:, 2] + states[:-1, 2]) / 2
    assert steps[:-1] == pytest.approx(0.1 * mean_speed[:-1])
    assert (states[:, 2] >= -1e-12).all()


def checked(distance: float, speed: float = 0.0, velocity: float = 6.0) -> tuple[str, float]:
    """Of a stop with a car so far ahead of the own one, bumper to bumper (behind, if negative)."""
    centre = 2.0 + math.copysign(abs(distance) + 2.0 + BMW_320I.length / 2, distance)
    pose, size = np.array([[centre, -1.0, 0.0]]), (np.array([4.0]), np.array([1.8]))
    truth = Obstacles.rectangles(pose, *size, np.array([speed]), last_step=30)
    asked = problem(velocity)
    record = judge_stop(emergency_stop(asked), asked, truth)
    assert record.reason == STOPPED
    return record.outcome, record.collision_time


def test_a_stop_touches_what_is_nearer_than_its_braking_distance() -> None:
    assert checked(2.26)[0] == "unplanned"
    outcome, time = checked(2.245)
    assert outcome == "collision"
    assert time == pytest.approx(0.8)
    assert checked(7.5, velocity=11.0)[0] == "collision"
    assert checked(7.6, velocity=11.0)[0] == "unplanned"


def test_who_follows_too_closely_runs_into_it() -> None:
    assert checked(-1.0, speed=8.0)[0] == "collision"
    assert checked(-10.0, speed=6.0)[0] == "unplanned"


def test_a_stop_is_no_safe_drive_and_has_no_cost() -> None:
    asked = problem(6.0)
    record = judge_stop(emergency_stop(asked), asked, Obstacles.none())
    assert not record.planned
    assert not record.safe
    numbers = (record.cost, record.path_length, record.travel_time, record.sm1_cost)
    assert all(math.isnan(number) for number in numbers)
