"""Heuristics: how far it is to the goal at least (complete mode) or about (reference mode)."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel
from avsec_gym.planners.goal import GoalArrays
from avsec_gym.planners.primitives import MotionPrimitives


class HeuristicLimits(NamedTuple):
    """The ego vehicle and what bounds the heuristic."""

    half_length: float
    half_width: float
    centre_offset: float
    """The distance from the rear axle to the centre, along the heading."""
    dt: float
    step_distance: float
    """No primitive moves the centre farther than this in one time step."""


@lru_cache(maxsize=64)
def heuristic_limits(primitives: MotionPrimitives) -> HeuristicLimits:
    """The limits of a vehicle that drives a set of primitives."""
    vehicle = primitives.vehicle
    heading = primitives.states[..., 3]
    centre = primitives.states[..., :2] + vehicle.rear_axle * np.stack(
        [np.cos(heading), np.sin(heading)], axis=-1
    )
    return HeuristicLimits(
        half_length=vehicle.length / 2,
        half_width=vehicle.width / 2,
        centre_offset=vehicle.rear_axle,
        dt=primitives.dt,
        step_distance=float(np.linalg.norm(np.diff(centre, axis=1), axis=-1).max()),
    )


@kernel(nogil=True)
def _distance_to_box(x: float, y: float, x1: float, x2: float, y1: float, y2: float) -> float:
    """Metres from a point to an axis-aligned box; 0 inside."""
    dx = 0.0 if x1 <= x <= x2 else min(abs(x1 - x), abs(x2 - x))
    dy = 0.0 if y1 <= y <= y2 else min(abs(y1 - y), abs(y2 - y))
    return np.sqrt(dx * dx + dy * dy)


@kernel(nogil=True)
def time_to_aim(x: float, y: float, velocity: float, step: int, goals: GoalArrays) -> float:
    """commonroad-search's heuristic: seconds to the first goal's box at the present speed.

    Where that goal asks for no place, the time steps until its window begins.
    """
    if goals.boxes[0, 0] == -np.inf:
        return float(goals.steps[0, 0] - step)
    if abs(velocity) <= 1e-8:
        return np.inf
    aim = goals.aim
    return _distance_to_box(x, y, aim[0], aim[1], aim[2], aim[3]) / velocity


@kernel(nogil=True)
def distance_to_goals(x: float, y: float, boxes: Floats) -> float:
    """Distance of the centre to the nearest goal's box."""
    best = np.inf
    for g in range(boxes.shape[0]):
        x1, x2, y1, y2 = boxes[g, 0], boxes[g, 1], boxes[g, 2], boxes[g, 3]
        best = min(best, _distance_to_box(x, y, x1, x2, y1, y2))
    return best


@kernel(nogil=True)
def steps_by_air(distance: float, step_distance: float) -> float:
    """Time steps for a way as the crow flies, at the greatest distance of any step; 1 at least."""
    if distance <= 0.0:
        return 1.0
    if step_distance <= 0.0:
        return np.inf
    return max(1.0, np.ceil(distance / step_distance - 1e-9))


@kernel(nogil=True)
def steps_in_time(nearest: float, step: int, windows: NDArray[np.int64]) -> float:
    """Time steps that it takes to a goal at least, by air and its window alone.

    Args:
        nearest: Steps that the way takes by air.
        step: The present time step.
        windows: The goals' first and last time steps, shape (G, 2).

    Returns:
        Whole steps; inf where every goal comes too late.
    """
    best = np.inf
    for g in range(windows.shape[0]):
        soonest, latest = _steps_in_window(nearest, step, windows, g)
        if soonest <= latest:
            best = min(best, soonest)
    return best


@kernel(nogil=True)
def steps_to_goal(
    x: float,
    y: float,
    heading: float,
    cos: float,
    sin: float,
    step: int,
    follow: int,
    nearest: float,
    windows: NDArray[np.int64],
    intervals: Floats,
    boxes: Floats,
    reach: Floats,
) -> float:
    """Time steps that any way from a rear-axle pose to any goal needs at least, by a reach table.

    Whole steps; inf where every goal comes too late.  ``nearest`` is how many it takes by air;
    windows, intervals and boxes are the goals' (`GoalArrays`), apart: to hand on all of its arrays
    at every node takes longer than what is done here.
    """
    # Invariant: `best` is the least of the goals so far, so that a goal is looked at only where it
    # may be reached sooner.
    best = np.inf
    for g in range(windows.shape[0]):
        soonest, latest = _steps_in_window(nearest, step, windows, g)
        if soonest > latest or soonest >= best:
            continue
        for j in range(int(soonest), latest + 1):
            if j >= best:
                break
            if _may_reach(x, y, heading, cos, sin, reach[follow, j], g, intervals, boxes):
                best = float(j)
    return best


@kernel(nogil=True)
def _steps_in_window(
    nearest: float, step: int, windows: NDArray[np.int64], goal: int
) -> tuple[float, int]:
    """The fewest and the most time steps after which a goal counts, by air and by its window."""
    return max(nearest, float(windows[goal, 0] - step)), windows[goal, 1] - step


@kernel(nogil=True)
def _may_reach(
    x: float,
    y: float,
    heading: float,
    cos: float,
    sin: float,
    bounds: Floats,
    g: int,
    intervals: Floats,
    boxes: Floats,
) -> bool:
    """Whether a box around reachable places, turned by a heading, meets a goal's box."""
    if bounds[0] > bounds[1]:
        return False
    # Rounding must not shut out a goal: places and headings may be so much farther apart.
    small = 1e-9
    turned = (heading + bounds[4] - intervals[g, 0] + small) % (2.0 * np.pi)
    beyond = turned > intervals[g, 1] + 2.0 * small
    if beyond and turned + bounds[5] - bounds[4] < 2.0 * np.pi:
        return False
    if boxes[g, 0] == -np.inf:
        return True
    box = boxes[g]
    gx, gy = 0.5 * (box[0] + box[1]) - x, 0.5 * (box[2] + box[3]) - y
    goal_x, goal_y = 0.5 * (box[1] - box[0]), 0.5 * (box[3] - box[2])
    bx, by = 0.5 * (bounds[0] + bounds[1]), 0.5 * (bounds[2] + bounds[3])
    half_x, half_y = 0.5 * (bounds[1] - bounds[0]), 0.5 * (bounds[3] - bounds[2])
    c, s = abs(cos), abs(sin)
    # Separating axes: the node's two, then the world's two.
    if abs(cos * gx + sin * gy - bx) > half_x + c * goal_x + s * goal_y + small:
        return False
    if abs(cos * gy - sin * gx - by) > half_y + s * goal_x + c * goal_y + small:
        return False
    if abs(gx - (cos * bx - sin * by)) > goal_x + c * half_x + s * half_y + small:
        return False
    return abs(gy - (sin * bx + cos * by)) <= goal_y + s * half_x + c * half_y + small
