"""How near a planned trajectory comes to what is really there."""

from __future__ import annotations

import math

import numpy as np
import shapely

from avsec_gym.geometry import Floats, rectangle_polygons
from avsec_gym.metrics.collision_check import present_poses, shapes_at
from avsec_gym.planners.vehicle import Vehicle
from avsec_gym.scenario.obstacles import Obstacles


def smallest_distance(
    trajectory: Floats, truth: Obstacles, vehicle: Vehicle, first_step: int = 0
) -> float:
    """The smallest distance between the vehicle's footprint and an obstacle at any time step, m.

    Args:
        trajectory: States x, y of the centre (m), velocity, heading (rad), steering angle, shape
            (T, 5).
        truth: Real obstacles.
        vehicle: The vehicle, of which the size counts.
        first_step: Time step of the trajectory's first state.

    Returns:
        0 where something is touched; infinite where nothing is there.

    Example:
        >>> from avsec_gym.planners.vehicle import BMW_320I
        >>> along_x = np.zeros((5, 5)); along_x[:, 0] = np.arange(5)
        >>> car = Obstacles.rectangles(np.array([[12.0, 0, 0]]), np.array([4.0]), np.array([2.0]))
        >>> round(smallest_distance(along_x, car, BMW_320I), 3)  # 8 m, less half of each length
        3.746
    """
    if not len(truth) or not len(trajectory):
        return math.inf
    present, poses = present_poses(len(trajectory), truth, first_step)
    t, i = np.nonzero(present)
    if not len(t):
        return math.inf
    own = trajectory[t][:, [0, 1, 3]]
    footprints = rectangle_polygons(own, vehicle.length, vehicle.width)
    return float(shapely.distance(footprints, shapes_at(truth.shapes, i, poses[t, i])).min())
