"""From detected boxes to a planning scenario (thesis, section 5.3; the authors' conversion)."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from avsec_gym.boxes import Boxes3D
from avsec_gym.geometry import Floats
from avsec_gym.image_only import check_places
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.constraints import driving_constraints
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.own_road import OwnRoad
from avsec_gym.scenario.planning_scenario import EgoState, Goal, PlanningScenario
from avsec_gym.scenario.road import Road, straight_lanes
from avsec_gym.scenario.shapes import Rectangle

OBSTACLE_CATEGORIES = ("Car", "Van", "Truck", "Misc")
"""KITTI's classes that become obstacles; pedestrians and cyclists do not, as with the authors."""

LANE_WIDTH = 3.5
GOAL_DISTANCE = 15.0
GOAL_LENGTH = 5.0
GOAL_HEADING = 0.5
GOAL_STEPS = (4, 30)
TIME_STEP = 0.1
_LANES = 27
"""As many lanes as on the authors' map: the road edge never binds."""


def build_planning_scenario(
    boxes: Boxes3D,
    *,
    road_type: RoadType = RoadType.STREET,
    intention: Intention = Intention.STRAIGHT,
    speeds: Floats | None = None,
    start_speed: float | None = None,
    id: str = "scenario",
    own_road: OwnRoad | None = None,
) -> PlanningScenario:
    """The problem that the motion planner gets: start, goal, lanes and obstacles.

    Args:
        boxes: Believed objects; classes that are no obstacles are left out.
        road_type: The road's type, which selects speeds and motion primitives.
        intention: Driving intention: the lane in which the goal lies.
        speeds: Speed of each box along its heading, m/s, shape (N,); None: all stand.
        start_speed: The ego vehicle's speed at the start; None: that of the road type.
        id: Id of the scenario.
        own_road: The road; None: the thesis' straight lanes.
    """
    constraints = driving_constraints(road_type)
    return PlanningScenario(
        id=id,
        start=EgoState(velocity=constraints.start_speed if start_speed is None else start_speed),
        goals=(goal_of(road_type, intention, own_road),),
        road=straight_road() if own_road is None else own_road.road,
        obstacles=obstacles_of(boxes, speeds),
        dt=TIME_STEP,
        road_type=RoadType(road_type),
        intention=Intention(intention),
    )


def goal_of(road_type: RoadType, intention: Intention, own_road: OwnRoad | None = None) -> Goal:
    """The goal region 15 m ahead in the lane that the intention names.

    Args:
        road_type: The road's type, which gives the speeds.
        intention: One that the road has a lane for.
        own_road: The road; None: the thesis' straight lanes.
    """
    if own_road is None:
        left = LANE_WIDTH * Intention(intention).lanes_to_the_left
        region = Rectangle(GOAL_LENGTH, LANE_WIDTH, GOAL_DISTANCE, left)
    else:
        region = own_road.stretch(intention, GOAL_DISTANCE, GOAL_LENGTH)
    return Goal(
        steps=GOAL_STEPS,
        region=(region,),
        heading=(region.heading - GOAL_HEADING, region.heading + GOAL_HEADING),
        velocity=driving_constraints(road_type).goal_velocity,
    )


@lru_cache(maxsize=1)
def straight_road() -> Road:
    """The authors' map: 27 straight lanes, the ego vehicle in the middle one."""
    return Road(straight_lanes(_LANES, LANE_WIDTH))


def obstacles_of(boxes: Boxes3D, speeds: Floats | None = None) -> Obstacles:
    """The boxes that count as obstacles, driving at constant velocity.

    Args:
        boxes: Boxes of N objects.
        speeds: Speeds, m/s, shape (N,); None: all stand.

    Raises:
        ConfigurationError: An obstacle is known in the image only.
    """
    keep = is_obstacle(boxes)
    check_places(boxes[keep])
    return Obstacles.rectangles(
        boxes.poses[keep],
        boxes.length[keep],
        boxes.width[keep],
        None if speeds is None else np.asarray(speeds, float)[keep],
        dt=TIME_STEP,
        last_step=GOAL_STEPS[1],
    )


def is_obstacle(boxes: Boxes3D) -> NDArray[np.bool_]:
    """Which boxes belong to a class that becomes an obstacle, shape (N,)."""
    return np.isin(boxes.category, OBSTACLE_CATEGORIES)


def draw_speeds(moving: NDArray[np.bool_], road_type: RoadType, seed: int, key: int) -> Floats:
    """Speeds of the moving objects, drawn once per object from the scenario's seed.

    Args:
        moving: Whether each object moves, shape (N,).
        road_type: Road type, which gives the range to draw from, uniformly.
        seed: The experiment's seed.
        key: The scenario's own number, so that scenarios draw independently.

    Returns:
        m/s, shape (N,); 0 for those that stand.
    """
    low, high = driving_constraints(road_type).others_speed
    drawn = np.random.default_rng([seed, key]).uniform(low, high, len(moving))
    return np.where(moving, drawn, 0.0)
