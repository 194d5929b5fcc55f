"""Why a search found nothing."""

from __future__ import annotations

import math

import numpy as np

from avsec_gym.planners.collision import CollisionWorld, collides, within_reach
from avsec_gym.planners.goal_room import occupied_steps
from avsec_gym.planners.plan import Reason, Status
from avsec_gym.planners.vehicle import Vehicle
from avsec_gym.scenario.planning_scenario import PlanningScenario


def why_nothing_was_found(
    status: Status, scenario: PlanningScenario, world: CollisionWorld, vehicle: Vehicle
) -> tuple[int, Reason]:
    """Time steps without room in the goal region, and the reason.

    Args:
        status: The status with which the search ended, not `FOUND`.
        scenario: The believed scenario.
        world: The obstacles and the road edge of the scenario.
        vehicle: The ego vehicle, whose size counts.
    """
    start = scenario.start
    at_start = (start.x, start.y, math.cos(start.heading), math.sin(start.heading))
    footprint = (vehicle.length / 2, vehicle.width / 2, start.step)
    free_ground = world._replace(edges=np.zeros((0, 4)))
    window = scenario.last_step - min(goal.steps[0] for goal in scenario.goals) + 1
    occupied = occupied_steps(scenario.goals, world, vehicle)
    if status == Status.LIMIT:
        return occupied, Reason.LIMIT
    if collides(*at_start, *footprint, free_ground):
        return occupied, Reason.START_OCCUPIED
    if collides(*at_start, *footprint, world):
        return occupied, Reason.OFF_ROAD
    if occupied == window:
        empty_road = within_reach(world, 0.0, 0.0, -math.inf)
        nowhere = occupied_steps(scenario.goals, empty_road, vehicle) == window
        return occupied, Reason.OFF_ROAD if nowhere else Reason.GOAL_OCCUPIED
    return occupied, Reason.UNREACHABLE
