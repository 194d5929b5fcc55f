"""Where believed objects will be: those that follow a lane stay in it where it bends.

Without that, what comes towards the car in a bend is believed to cross the car's lane, and the car
swings out of its way into the lane in which the other really comes.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from avsec_gym.closed_loop.lanes import Lanes
from avsec_gym.geometry import Floats
from avsec_gym.scenario.obstacles import Obstacles


def following_lanes(obstacles: Obstacles, lanes: Lanes, dt: float) -> Obstacles:
    """Obstacles at constant velocity, of which those that follow a lane turn as the lane does.

    Their velocity is constant in the lane's coordinates, along it and to its left: on a straight
    lane that is the same, and one that changes lanes in a bend goes on to change them.  What is
    in no lane or crosses one keeps its heading; so does what drives beyond a fork, where its way
    is not known.

    Args:
        obstacles: The obstacles; those that move do so at constant velocity along their heading.
        lanes: The lanes of the road.
        dt: Length of a time step, seconds.
    """
    moving = np.flatnonzero(~obstacles.static)
    if not lanes.bend or not len(moving):
        return obstacles
    poses = obstacles.poses.copy()
    for i in moving.tolist():
        way = obstacles.speeds[i, 0] * dt * np.arange(poses.shape[1])
        followed = _along_lane(poses[i, 0], way, lanes)
        if followed is not None:
            poses[i] = followed
    return replace(obstacles, poses=poses)


def _along_lane(start: Floats, way: Floats, lanes: Lanes) -> Floats | None:
    """Poses after some ways along the lane that is followed, shape (T, 3); None: none is.

    Args:
        start: Pose x, y, heading.
        way: Metres driven, from 0 on, shape (T,).
        lanes: The lanes of the road.
    """
    x, y, heading = start.tolist()
    lane = lanes.followed(x, y, heading)
    if lane is None:
        return None
    line = lanes.line(lane, through_forks=False)
    along, left = line.coordinates(x, y)
    turned = heading - line.heading(along)
    poses = line.poses(along + way * math.cos(turned), left + way * math.sin(turned))
    poses[:, 2] += heading - poses[0, 2]
    return poses
