"""Whose fault a collision is: the rule of nuPlan and NAVSIM (Dauner et al., NeurIPS 2024).

In this order:

1. the car stands: not at fault;
2. the other stands: at fault;
3. the other's centre lies behind the car's rear axle, within 30 degrees of straight back: not at
   fault;
4. the car's front bumper touches the other: at fault;
5. the sides touch: at fault where the car is in more than one lane, or not wholly on the road.
"""

from __future__ import annotations

import math

import numpy as np
import shapely
from numpy.typing import NDArray

from avsec_gym.closed_loop.drive_log import DriveContact, DriveLog
from avsec_gym.closed_loop.lanes import Lanes
from avsec_gym.geometry import Floats, rectangle_corners, rectangle_polygons, wrap_angle
from avsec_gym.planners.vehicle import BMW_320I

STANDING = 0.05
"""m/s: slower vehicles stand."""
_AHEAD, _BEHIND = math.radians(30), math.radians(150)
"""Angle off straight ahead below which an actor is ahead, and above which it is behind."""


def at_fault(
    log: DriveLog, contact: DriveContact, lanes: Lanes, drivable: shapely.Geometry
) -> bool:
    """Whether the car is to blame for a contact.

    Args:
        log: The drive.
        contact: The first touch of an actor.
        lanes: The lanes of the road.
        drivable: The area that may be driven on.
    """
    step, actor = contact.step, contact.actor
    car, pose = log.car[step], log.poses[step, actor]
    if abs(car[2]) <= STANDING:
        return False
    if abs(log.speeds[step, actor]) <= STANDING:
        return True
    if is_behind(car, pose):
        return False
    corners = rectangle_corners(car[[0, 1, 3]], BMW_320I.length, BMW_320I.width)
    other = rectangle_polygons(pose, log.sizes[actor, 0], log.sizes[actor, 1])
    # Corners are counted counter-clockwise from front left: the bumper joins the first and last.
    if shapely.intersects(shapely.LineString(corners[[0, 3]]), other):
        return True
    return astride(car, lanes, drivable)


def is_ahead(car: Floats, pose: Floats) -> NDArray[np.bool_]:
    """Whether an actor's centre lies ahead of the car's rear axle, within 30 degrees.

    Args:
        car: States of the car, shape (..., 5).
        pose: Poses of actors, shape (..., 3).
    """
    return np.abs(_bearing(car, pose)) < _AHEAD


def is_behind(car: Floats, pose: Floats) -> NDArray[np.bool_]:
    """Whether an actor's centre lies behind the car's rear axle, within 30 degrees.

    Args:
        car: States of the car, shape (..., 5).
        pose: Poses of actors, shape (..., 3).
    """
    return np.abs(_bearing(car, pose)) > _BEHIND


def astride(car: Floats, lanes: Lanes, drivable: shapely.Geometry) -> bool:
    """Whether the car's corners lie in more than one lane, or off the road."""
    corners = rectangle_corners(car[[0, 1, 3]], BMW_320I.length, BMW_320I.width)
    if not shapely.contains_xy(drivable, corners[:, 0], corners[:, 1]).all():
        return True
    return all(
        not shapely.contains_xy(area, corners[:, 0], corners[:, 1]).all() for area in lanes.areas
    )


def _bearing(car: Floats, pose: Floats) -> Floats:
    offset, heading = BMW_320I.rear_axle, car[..., 3]
    x, y = car[..., 0] - offset * np.cos(heading), car[..., 1] - offset * np.sin(heading)
    return wrap_angle(np.arctan2(pose[..., 1] - y, pose[..., 0] - x) - heading)
