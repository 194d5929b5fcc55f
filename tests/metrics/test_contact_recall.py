"""Weights by the time to contact, worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.metrics.contact_recall import (
    contact_weights,
    straight_way,
)
from avsec_gym.planners.vehicle import BMW_320I
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.builder import build_planning_scenario
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.planning_scenario import PlanningScenario


def scenario(
    *cars: tuple[list[float], float, float, float],
    road_type: RoadType = RoadType.STREET,
    intention: Intention = Intention.STRAIGHT,
) -> PlanningScenario:
    empty = build_planning_scenario(Boxes3D.empty(), road_type=road_type, intention=intention)
    poses, lengths, widths, speeds = zip(*cars, strict=True) if cars else ([], [], [], [])
    sizes = (np.array(lengths), np.array(widths))
    speed = np.array(speeds) if any(speeds) else None
    there = np.array(poses).reshape(-1, 3)
    return empty.with_obstacles(Obstacles.rectangles(there, *sizes, speed, last_step=30))


def weights(*cars: tuple[list[float], float, float, float], **kwargs: Intention) -> list[float]:
    problem: PlanningScenario = scenario(*cars, **kwargs)
    found: list[float] = contact_weights(problem).tolist()
    return found


def test_an_object_ahead_weighs_by_the_time_until_it_is_near() -> None:
    # The gap is 20 - 2 - 2.254 m; 0.5 m of it are near; at 6 m/s that takes 2.54 s: 26 steps.
    assert weights(([20.0, 0, 0], 4.0, 1.8, 0.0)) == [pytest.approx(1 / (1 + 2.6))]
    assert (20 - 2 - 0.5 * BMW_320I.length - 0.5) / 6 == pytest.approx(2.54, abs=0.005)
    # Touched at once.
    assert weights(([3.0, 0, 0], 4.0, 1.8, 0.0)) == [1]


def test_what_is_passed_at_a_distance_or_far_off_weighs_nothing() -> None:
    # Half widths are 0.805 and 0.9 m: 2.2 m aside leaves 0.495 m, 2.3 m more than 0.5 m.
    near, aside = ([10.0, 2.2, 0], 4.0, 1.8, 0.0), ([10.0, 2.3, 0], 4.0, 1.8, 0.0)
    far, behind = ([40.0, 0, 0], 4.0, 1.8, 0.0), ([-8.0, 0, 0], 4.0, 1.8, 0.0)
    found = weights(near, aside, far, behind)
    assert found[0] > 0.4
    assert found[1:] == [0, 0, 0]


def test_what_drives_on_as_fast_is_never_near() -> None:
    ahead = [12.0, 0, 0]
    assert weights((ahead, 4.0, 1.8, 7.0)) == [0]
    assert weights((ahead, 4.0, 1.8, 0.0))[0] > 0
    # Towards the car at 7 m/s: the gap of 7.746 m less 0.5 m closes at 13 m/s, in 0.557 s.
    assert weights(([12.0, 0, np.pi], 4.0, 1.8, 7.0)) == [pytest.approx(1 / 1.6)]


def test_the_way_leads_to_the_goal_of_the_intention() -> None:
    left = straight_way(scenario(intention=Intention.LEFT))
    assert left[0].tolist()[:2] == [0, 0]
    assert left[-1, 1] / left[-1, 0] == pytest.approx(3.5 / 15)
    assert np.hypot(*left[-1, :2]) == pytest.approx(6.0 * 3.0)
    in_left_lane = ([14.0, 4.0, 0], 4.0, 1.8, 0.0)
    assert weights(in_left_lane, intention=Intention.LEFT)[0] > 0
    assert weights(in_left_lane, intention=Intention.RIGHT) == [0]
