"""A goal region that is proven full has no free pose in it."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from avsec_gym.geometry import rectangle_polygons
from avsec_gym.planners.collision import obstacle_world
from avsec_gym.planners.goal_room import is_full, occupied_steps
from avsec_gym.planners.vehicle import BMW_320I
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.planning_scenario import Goal
from avsec_gym.scenario.road import Road, straight_lanes
from avsec_gym.scenario.shapes import Disc, Rectangle

SIZE = np.array(BMW_320I.length), np.array(BMW_320I.width)


def random_case(seed: int) -> tuple[Goal, Obstacles, Road]:
    """Obstacles with gaps between them that the car may just fit into."""
    rng = np.random.default_rng(seed)
    region = (Rectangle(5.0, 3.5, 15.0, 0.0, 0.2), Disc(2.0, 15.0, 0.0))[seed % 2]
    heading = (-0.5, 0.5) if seed % 3 else None
    x = np.arange(9.0, 22.0, 1.5)
    poses = np.column_stack([x, rng.uniform(-1.5, 1.5, len(x)), rng.uniform(-0.3, 0.3, len(x))])
    obstacles = Obstacles.rectangles(
        poses, rng.uniform(0.2, 2, len(x)), rng.uniform(1, 5, len(x)), last_step=9
    )
    return Goal((3, 6), (region,), heading), obstacles, Road(straight_lanes(3, 3.5, -10, 40))


@pytest.mark.parametrize("seed", range(24))
def test_no_pose_in_a_full_region_is_free(seed: int) -> None:
    goal, obstacles, road = random_case(seed)
    world = obstacle_world(obstacles, road.edges)
    if not is_full((goal,), world, BMW_320I):
        return
    assert occupied_steps((goal,), world, BMW_320I) == 4
    rng = np.random.default_rng(seed)
    low, high = goal.heading or (0.0, 2 * np.pi)
    assert goal.region
    area = goal.region[0].polygon()
    poses = rng.uniform((12, -3, low), (18, 3, high), (4000, 3))
    poses = poses[shapely.contains_xy(area, poses[:, 0], poses[:, 1])]
    cars = rectangle_polygons(poses, SIZE[0], SIZE[1])
    blocked = shapely.union_all(obstacles.polygons(3))
    assert (shapely.intersects(cars, blocked) | ~shapely.covers(road.area, cars)).all()


def test_the_cases_are_of_both_kinds() -> None:
    full = 0
    for seed in range(24):
        goal, obstacles, road = random_case(seed)
        full += is_full((goal,), obstacle_world(obstacles, road.edges), BMW_320I)
    assert 2 < full < 22


def test_a_car_that_drives_off_leaves_room_in_time() -> None:
    goal = Goal((0, 30), (Rectangle(1.0, 1.0, 15.0, 0.0),), (-0.1, 0.1))
    pose, size = np.array([[15.0, 0.0, 0.0]]), np.array([4.0])
    for speed, full in ((0.0, True), (1.0, True), (6.0, False)):
        car = Obstacles.rectangles(pose, size, size / 2, np.array([speed]), last_step=30)
        world = obstacle_world(car, np.zeros((0, 4)))
        assert is_full((goal,), world, BMW_320I) == full
    assert not is_full((goal, Goal((0, 30))), world, BMW_320I)


def test_a_goal_beside_the_road_is_full() -> None:
    world = obstacle_world(Obstacles.none(), Road(straight_lanes(1)).edges)
    for y, full in ((0.0, False), (30.0, True)):
        goal = Goal((0, 3), (Rectangle(3.0, 3.0, 15.0, y),))
        assert is_full((goal,), world, BMW_320I) == full
