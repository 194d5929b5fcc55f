"""From detected boxes to a planning problem (protocol A1)."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.builder import build_planning_scenario, draw_speeds, goal_of
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.shapes import Rectangle


def boxes(*categories: str) -> Boxes3D:
    count = len(categories)
    return Boxes3D(
        location=np.column_stack(
            [np.arange(count) * 3.0, np.full(count, 1.7), np.full(count, 20.0)]
        ),
        dimensions=np.tile([1.5, 1.6, 3.9], (count, 1)),
        rotation_y=np.full(count, -np.pi / 2),
        score=np.ones(count),
        category=np.array(categories),
    )


@pytest.mark.parametrize(
    ("intention", "y"), [(Intention.LEFT, 3.5), (Intention.STRAIGHT, 0.0), (Intention.RIGHT, -3.5)]
)
def test_goal_region(intention: Intention, y: float) -> None:
    goal = goal_of(RoadType.STREET, intention)
    assert goal.region == (Rectangle(5.0, 3.5, 15.0, y),)
    assert goal.heading == (-0.5, 0.5)
    assert goal.steps == (4, 30)
    assert goal.velocity == (6.0, 8.0)
    assert goal_of(RoadType.HIGHWAY, intention).velocity == (11.0, 13.0)


def test_start_and_road() -> None:
    scenario = build_planning_scenario(Boxes3D.empty(), road_type=RoadType.HIGHWAY, id="000123")
    assert scenario.id == "000123"
    assert (scenario.start.x, scenario.start.y, scenario.start.heading) == (0, 0, 0)
    assert scenario.start.velocity == 11.0
    assert build_planning_scenario(Boxes3D.empty()).start.velocity == 6.0
    assert build_planning_scenario(Boxes3D.empty(), start_speed=7.3).start.velocity == 7.3
    assert len(scenario.road.lanelets) == 27
    assert scenario.road.area.bounds[1::2] == pytest.approx((-47.25, 47.25))
    assert scenario.dt == 0.1


def test_only_vehicles_become_obstacles() -> None:
    kinds = ("Car", "Pedestrian", "Van", "Truck", "Cyclist", "Misc", "Tram", "DontCare")
    scenario = build_planning_scenario(boxes(*kinds), speeds=np.arange(8.0))
    assert len(scenario.obstacles) == 4
    np.testing.assert_allclose(scenario.obstacles.poses[:, 0, 0], 20.0)
    np.testing.assert_allclose(scenario.obstacles.poses[:, 0, 1], [0.0, -6.0, -9.0, -15.0])
    np.testing.assert_allclose(scenario.obstacles.poses[:, 0, 2], 0.0, atol=1e-12)
    assert scenario.obstacles.shapes[0] == Rectangle(3.9, 1.6)
    np.testing.assert_array_equal(scenario.obstacles.speeds[:, 0], [0, 2, 3, 5])
    assert scenario.obstacles.static.tolist() == [True, False, False, False]
    # Predicted as far as the goal's time window goes.
    assert scenario.obstacles.poses[1, 30, 0] == pytest.approx(20.0 + 2.0 * 3.0)


def test_drawn_speeds() -> None:
    moving = np.array([True, False, True, True])
    street = draw_speeds(moving, RoadType.STREET, seed=0, key=7)
    assert street[1] == 0
    assert ((street[moving] >= 6) & (street[moving] <= 8)).all()
    np.testing.assert_array_equal(street, draw_speeds(moving, RoadType.STREET, seed=0, key=7))
    assert (street != draw_speeds(moving, RoadType.STREET, seed=0, key=8))[moving].all()
    assert (street != draw_speeds(moving, RoadType.STREET, seed=1, key=7))[moving].all()
    highway = draw_speeds(moving, RoadType.HIGHWAY, seed=0, key=7)
    assert ((highway[moving] >= 11) & (highway[moving] <= 13)).all()
    # An object's speed does not depend on whether others move.
    np.testing.assert_array_equal(
        draw_speeds(np.ones(4, bool), RoadType.STREET, seed=0, key=7)[moving], street[moving]
    )
