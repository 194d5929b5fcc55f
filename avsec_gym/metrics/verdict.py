"""The verdict: does a planned trajectory touch anything that is really there?

Taken with shapely against the ground truth, at every time step, moving objects moving; the
planner's own collision test is not used (thesis, section 5.3.1: "a collision [is] the physical
contact of objects").
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import shapely

from avsec_gym.geometry import Floats, rectangle_corners, rectangle_polygons
from avsec_gym.planners.vehicle import Vehicle
from avsec_gym.scenario.planning_scenario import Obstacles
from avsec_gym.scenario.shapes import Rectangle, Shape


@dataclass(frozen=True)
class Contact:
    """The first touch."""

    step: int
    """Time step."""
    obstacle: int
    """Row of the obstacle."""


def first_contact(
    trajectory: Floats, truth: Obstacles, vehicle: Vehicle, first_step: int = 0
) -> Contact | None:
    """The first time step at which the vehicle's footprint touches an obstacle.

    Args:
        trajectory: x, y of the centre (m), velocity, heading (rad), steering angle, shape (T, 5).
        truth: What is really there.
        vehicle: Its size.
        first_step: Time step of the trajectory's first state.

    Returns:
        None where nothing is touched at any time step.

    Example:
        >>> from avsec_gym.planners.vehicle import BMW_320I
        >>> along_x = np.zeros((30, 5)); along_x[:, 0] = np.arange(30)
        >>> car = Obstacles.rectangles(np.array([[12.0, 0, 0]]), np.array([4.0]), np.array([2.0]))
        >>> first_contact(along_x, car, BMW_320I)
        Contact(step=8, obstacle=0)
    """
    if not len(truth) or not len(trajectory):
        return None
    steps = first_step + np.arange(len(trajectory))
    index = np.minimum(steps[:, None] - truth.first_step, truth.steps - 1)
    present = truth.static | (index >= 0)
    index = np.where(truth.static, 0, np.maximum(index, 0))
    poses = truth.poses[np.arange(len(truth)), index]
    reach = np.array([_reach(shape) for shape in truth.shapes])
    own_reach = 0.5 * np.hypot(vehicle.length, vehicle.width)
    apart = np.hypot(poses[..., 0] - trajectory[:, None, 0], poses[..., 1] - trajectory[:, None, 1])
    t, i = np.nonzero(present & (apart <= reach + own_reach + 1e-6))
    if not len(t):
        return None
    footprints = rectangle_polygons(trajectory[:, [0, 1, 3]], vehicle.length, vehicle.width)
    touching = shapely.intersects(footprints[t], _placed(truth.shapes, i, poses[t, i]))
    if not touching.any():
        return None
    first = int(np.argmax(touching))
    return Contact(int(steps[t[first]]), int(i[first]))


def _placed(shapes: tuple[Shape, ...], which: np.ndarray, poses: Floats) -> np.ndarray:
    """Shapes moved to poses, as shapely geometries, shape (K,)."""
    data = np.array(
        [
            (s.length, s.width, s.x, s.y, s.heading) if isinstance(s, Rectangle) else (np.nan,) * 5
            for s in shapes
        ]
    )[which]
    if not np.isnan(data).any() and not data[:, 2:].any():
        return rectangle_polygons(poses, data[:, 0], data[:, 1])
    placed = np.empty(len(which), object)
    for row, (shape, (x, y, heading)) in enumerate(
        zip((shapes[i] for i in which), poses, strict=True)
    ):
        turn = np.array([[np.cos(heading), np.sin(heading)], [-np.sin(heading), np.cos(heading)]])
        placed[row] = shapely.transform(
            _polygon(shape), lambda points, turn=turn, at=(x, y): points @ turn + at
        )
    return placed


@lru_cache(maxsize=1024)
def _polygon(shape: Shape) -> shapely.Geometry:
    return shape.polygon()


def _reach(shape: Shape) -> float:
    """Largest distance of a shape's points from its origin."""
    if isinstance(shape, Rectangle) and shape.x == shape.y == 0.0:
        return 0.5 * float(np.hypot(shape.length, shape.width))
    points = shapely.get_coordinates(_polygon(shape))
    return float(np.hypot(points[:, 0], points[:, 1]).max())


def footprints(trajectory: Floats, vehicle: Vehicle) -> Floats:
    """Corners of the vehicle at every state of a trajectory, shape (T, 4, 2)."""
    return rectangle_corners(trajectory[:, [0, 1, 3]], vehicle.length, vehicle.width)
