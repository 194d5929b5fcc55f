"""The collision check: does a planned trajectory touch anything that is really there?

Made with shapely against the ground truth, at every time step, moving objects moving; the
planner's own collision test is not used (thesis, section 5.3.1: "a collision [is] the physical
contact of objects").
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from avsec_gym.geometry import Floats, rectangle_corners, rectangle_polygons
from avsec_gym.kernels import kernel
from avsec_gym.planners.vehicle import Vehicle
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.shapes import Rectangle, Shape, members, placed

_SMALL = 1e-6
"""A length that counts as none, metres."""


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
        trajectory: States x, y of the centre (m), velocity, heading (rad), steering angle, shape
            (T, 5).
        truth: Real obstacles.
        vehicle: The vehicle, of which the size counts.
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
    present, poses = present_poses(len(trajectory), truth, first_step)
    # Pairs of step and obstacle that may touch, in order of time; shapely decides them.
    reach = np.array([_reach(shape) for shape in truth.shapes])
    own = trajectory[:, [0, 1, 3]]
    near = _may_touch(own[:, None], vehicle.length, vehicle.width, poses, reach)
    t, i = np.nonzero(present & near)
    if not len(t):
        return None
    footprints = rectangle_polygons(own[t], vehicle.length, vehicle.width)
    touching = shapely.intersects(footprints, shapes_at(truth.shapes, i, poses[t, i]))
    if not touching.any():
        return None
    first = int(np.argmax(touching))
    return Contact(int(steps[t[first]]), int(i[first]))


def present_poses(
    count: int, truth: Obstacles, first_step: int = 0
) -> tuple[NDArray[np.bool_], Floats]:
    """Which obstacles are present at each time step, and where; the last known pose is kept.

    Args:
        count: Number of time steps, T.
        truth: N obstacles.
        first_step: The first time step.

    Returns:
        Flags of shape (T, N), and poses x, y, heading of shape (T, N, 3).
    """
    steps = first_step + np.arange(count)
    index = np.minimum(steps[:, None] - truth.first_step, truth.steps - 1)
    present = truth.static | (index >= 0)
    index = np.where(truth.static, 0, np.maximum(index, 0))
    return present, truth.poses[np.arange(len(truth)), index]


class TrajectoryBatch(NamedTuple):
    """B trajectories, each among N rectangles that are really there."""

    trajectories: Floats
    """States from time step 0 on, shape (B, T, 5)."""
    lengths: NDArray[np.int64]
    """Number of states of each; what stands behind them is not looked at, shape (B,)."""
    poses: Floats
    """Poses x, y, cos, sin of the headings of the rectangles at the same steps, shape
    (B, N, T, 4), or at all of them, (B, N, 1, 4)."""
    half_sizes: Floats
    """Half length and half width of the rectangles, shape (B, N, 2)."""


def batch_collides(batch: TrajectoryBatch, vehicle: Vehicle) -> NDArray[np.bool_]:
    """Whether trajectories touch rectangles: `first_contact` for many scenarios at once.

    Args:
        batch: The trajectories, and what is really there.
        vehicle: The vehicle, of which the size counts.

    Returns:
        Shape (B,).
    """
    trajectories, lengths, poses, half_sizes = batch
    reach = np.hypot(half_sizes[..., 0], half_sizes[..., 1])
    b, i, t = _near(trajectories, lengths, poses, reach, 0.5 * vehicle.length, 0.5 * vehicle.width)
    if not len(b):
        return np.zeros(len(trajectories), bool)
    footprints = rectangle_polygons(trajectories[b, t][:, [0, 1, 3]], vehicle.length, vehicle.width)
    pose, half = poses[b, i, t if poses.shape[2] > 1 else 0], half_sizes[b, i]
    heading = np.arctan2(pose[:, 3], pose[:, 2])
    others = rectangle_polygons(
        np.column_stack([pose[:, :2], heading]), 2 * half[:, 0], 2 * half[:, 1]
    )
    collides = np.zeros(len(trajectories), bool)
    collides[b[shapely.intersects(footprints, others)]] = True
    return collides


@kernel(nogil=True)
def _near(
    trajectories: Floats,
    lengths: NDArray[np.int64],
    poses: Floats,
    reach: Floats,
    half_length: float,
    half_width: float,
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Trajectory, rectangle and step wherever `_may_touch` holds.

    Invariant: rows 0 to `count` - 1 are filled; the memory doubles when it is full.
    """
    rows = np.empty((64, 3), np.int64)
    count, moves = 0, poses.shape[2] > 1
    for b in range(trajectories.shape[0]):
        for t in range(min(lengths[b], trajectories.shape[1])):
            x, y, heading = trajectories[b, t, 0], trajectories[b, t, 1], trajectories[b, t, 3]
            cos, sin = np.cos(heading), np.sin(heading)
            for i in range(poses.shape[1]):
                dx = poses[b, i, t if moves else 0, 0] - x
                dy = poses[b, i, t if moves else 0, 1] - y
                far = reach[b, i] + _SMALL
                if abs(cos * dx + sin * dy) > half_length + far:
                    continue
                if abs(cos * dy - sin * dx) > half_width + far:
                    continue
                if count == rows.shape[0]:
                    rows = np.concatenate((rows, np.empty_like(rows)))
                rows[count, 0], rows[count, 1], rows[count, 2] = b, i, t
                count += 1
    return rows[:count, 0], rows[:count, 1], rows[:count, 2]


def _may_touch(
    own: Floats, length: float, width: float, poses: Floats, reach: Floats
) -> NDArray[np.bool_]:
    """False where a disc around an object stays clear of the vehicle: no need to ask shapely."""
    dx, dy = poses[..., 0] - own[..., 0], poses[..., 1] - own[..., 1]
    cos, sin = np.cos(own[..., 2]), np.sin(own[..., 2])
    ahead, aside = np.abs(cos * dx + sin * dy), np.abs(cos * dy - sin * dx)
    return (ahead <= 0.5 * length + reach + _SMALL) & (aside <= 0.5 * width + reach + _SMALL)


def shapes_at(
    shapes: tuple[Shape, ...], which: NDArray[np.int64], poses: Floats
) -> NDArray[np.object_]:
    """Shapes moved to poses, as shapely geometries, shape (K,).

    Args:
        shapes: The shapes of N obstacles.
        which: Rows of the obstacles to be moved, shape (K,).
        poses: Where each is moved to, x, y, heading, shape (K, 3).
    """
    data = np.array(
        [
            (s.length, s.width, s.x, s.y, s.heading) if isinstance(s, Rectangle) else (np.nan,) * 5
            for s in shapes
        ]
    )[which]
    if not np.isnan(data).any() and not data[:, 2:].any():
        return rectangle_polygons(poses, data[:, 0], data[:, 1])
    areas = np.empty(len(which), object)
    for row, (i, pose) in enumerate(zip(which, poses, strict=True)):
        areas[row] = placed(shapes[i], pose)
    return areas


@lru_cache(maxsize=1024)
def _reach(shape: Shape) -> float:
    """Largest distance of a shape's points from its obstacle's position, however it is turned."""
    if isinstance(shape, Rectangle) and shape.x == shape.y == 0.0:
        return 0.5 * float(np.hypot(shape.length, shape.width))
    largest = 0.0
    for member in members(shape):
        away = shapely.get_coordinates(member.polygon()) - member.centre
        largest = max(largest, np.hypot(*member.centre) + np.hypot(*away.T).max())
    return float(largest)


def footprints(trajectory: Floats, vehicle: Vehicle) -> Floats:
    """Corners of the vehicle at every state of a trajectory, shape (T, 4, 2)."""
    return rectangle_corners(trajectory[:, [0, 1, 3]], vehicle.length, vehicle.width)
