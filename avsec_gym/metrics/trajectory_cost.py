"""What a trajectory costs: length and time as the authors measure them, and CommonRoad's SM1."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from avsec_gym.geometry import Floats, wrap_angle
from avsec_gym.scenario.planning_scenario import PlanningScenario
from avsec_gym.scenario.road import Road

ACCELERATION = STEERING_ANGLE = STEERING_RATE = HEADING = 50.0
SPEED, LENGTH = 20.0, 1.0
"""Weights of SM1."""


def path_length(trajectory: Floats) -> float:
    """Sum of the distances between successive states, m.

    Args:
        trajectory: States, x and y first, shape (T, 5).
    """
    return float(np.linalg.norm(np.diff(trajectory[:, :2], axis=0), axis=1).sum())


def travel_time(trajectory: Floats, dt: float) -> float:
    """Time from the first to the last state, s."""
    return (len(trajectory) - 1) * dt


def sm1_cost(trajectory: Floats, scenario: PlanningScenario) -> float:
    """CommonRoad's cost function SM1 (after Magdici and Althoff, "Fail-safe motion planning").

    Weighted sum of integrals over time (Simpson's rule): 50 each for squared acceleration, steering
    angle, steering rate and heading against the lane, 20 for the squared distance to the goal's
    lowest speed, 1 for the path length.

    Args:
        trajectory: States as centre x, y, velocity, heading, steering angle, shape (T, 5).
        scenario: The scenario, whose goal gives the speed to keep, its road the lanes' directions.
    """
    velocity, heading, steering = trajectory[:, 2], trajectory[:, 3], trajectory[:, 4]
    wanted = [goal.velocity[0] for goal in scenario.goals if goal.velocity]
    turned = wrap_angle(heading - lane_heading(trajectory[:, :2], scenario.road))
    at_states = (
        STEERING_ANGLE * steering**2
        + LENGTH * velocity
        + (SPEED * (min(wanted) - velocity) ** 2 if wanted else 0.0)
        + HEADING * turned**2
    )
    between_states = (
        ACCELERATION * np.diff(velocity) ** 2 + STEERING_RATE * np.diff(steering) ** 2
    ) / scenario.dt**2
    return float(
        at_states @ simpson_weights(len(at_states), scenario.dt)
        + between_states @ simpson_weights(len(between_states), scenario.dt)
    )


@lru_cache(maxsize=1024)
def simpson_weights(count: int, dx: float) -> Floats:
    """Weights of Simpson's rule for so many equally spaced samples, shape (count,).

    With an even number, the last interval gets Cartwright's correction, as in scipy, which takes
    too long to import for a sum.
    """
    weights = np.zeros(count)
    if count == 2:
        weights[:] = 0.5
    elif count > 2:
        odd = count - 1 + count % 2
        weights[:odd:2], weights[1:odd:2] = 2 / 3, 4 / 3
        weights[0] = weights[odd - 1] = 1 / 3
        if odd < count:
            weights[-3:] += np.array([-1.0, 8.0, 5.0]) / 12
    return weights * dx


def lane_heading(points: Floats, road: Road) -> Floats:
    """Direction of the nearest lane's centre line at each point; 0 where there is no road.

    Args:
        points: Points x, y, shape (T, 2).
        road: The lanelets.

    Returns:
        Radians, shape (T,).
    """
    starts, ends = road.centre_segments
    if not len(starts):
        return np.zeros(len(points))
    along = ends - starts
    relative = points[:, None, :] - starts
    share = np.clip((relative * along).sum(-1) / (along**2).sum(-1), 0.0, 1.0)
    distance = np.linalg.norm(relative - share[..., None] * along, axis=-1)
    nearest = along[np.argmin(distance, axis=1)]
    return np.arctan2(nearest[:, 1], nearest[:, 0])
