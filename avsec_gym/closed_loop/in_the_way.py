"""Which obstacles may be in the way of a plan: few of those that `is_fail_safe` is asked about.

The first look of `first_swept_contact` at every time step, at the extent of the vehicle in the
obstacle's own frame, in microseconds.  What it leaves out is never touched; what is left is to be
looked at exactly, which takes a millisecond.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avsec_gym.closed_loop.angles import wrapped
from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel
from avsec_gym.metrics.swept_contact import TOLERANCE
from avsec_gym.planners.vehicle import BMW_320I
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.shapes import Rectangle

_ROUNDING = 1e-6
"""Metres by which everything is larger than for the exact answer."""


def in_the_way(
    way: Floats,
    obstacles: Obstacles,
    counted: NDArray[np.bool_],
    *,
    margin: float,
    brake: float,
    dt: float,
) -> NDArray[np.bool_]:
    """Which obstacles a way may touch, where those that drive go on, or brake from now on.

    Args:
        way: States of the vehicle at every `dt`, shape (T, 5).
        obstacles: N obstacles, from the first of these states on.
        counted: The obstacles that are asked about, shape (N,).
        margin: Metres by which all that moves reaches further on all sides.
        brake: Deceleration, m/s2, of those that brake, until they stand.
        dt: Length of a time step, seconds.

    Returns:
        Shape (N,): false where an obstacle is surely not touched, or not asked about.
    """
    shapes = obstacles.shapes
    if obstacles.first_step.any() or not all(
        type(each) is Rectangle and each.is_centred for each in shapes
    ):
        return counted
    sizes = np.array([(each.length, each.width) for each in shapes]).reshape(-1, 2)  # type: ignore[union-attr]
    half = 0.5 * sizes + np.where(obstacles.static, 0.0, margin)[:, None] + _ROUNDING
    own = 0.5 * BMW_320I.length, 0.5 * BMW_320I.width
    last = np.where(obstacles.static, 0, obstacles.steps - 1)
    # The kernel is compiled for arrays that can be written into; those of obstacles cannot.
    poses, speeds = obstacles.poses.copy(), obstacles.speeds.copy()
    found = _in_the_way(way, poses, speeds, last, counted, half, own, brake, dt)
    return np.asarray(found)


@kernel(nogil=True)
def _in_the_way(
    way: Floats,
    poses: Floats,
    speeds: Floats,
    last: NDArray[np.int64],
    counted: NDArray[np.bool_],
    half: Floats,
    own: tuple[float, float],
    brake: float,
    dt: float,
) -> NDArray[np.bool_]:
    """`in_the_way` of rectangles of half the length and width `half`; `last` is their last step."""
    found = np.zeros(len(poses), np.bool_)
    begin, end = np.empty(3), np.empty(3)
    for i in range(len(poses)):
        if not counted[i]:
            continue
        for t in range(len(way) - 1):
            now, then = min(t, last[i]), min(t + 1, last[i])
            # As it drives on.
            if _may_touch(way[t], way[t + 1], poses[i, now], poses[i, then], half[i], own):
                found[i] = True
                break
            # As it brakes.
            if last[i] == 0 or speeds[i, 0] <= 0.0:
                continue
            _braking(poses[i], speeds[i, 0], now, brake, dt, begin)
            _braking(poses[i], speeds[i, 0], then, brake, dt, end)
            if _may_touch(way[t], way[t + 1], begin, end, half[i], own):
                found[i] = True
                break
    return found


@kernel(nogil=True)
def _braking(poses: Floats, speed: float, step: int, brake: float, dt: float, pose: Floats) -> None:
    """Where a vehicle is that brakes from its start on, along its way at constant speed.

    Args:
        poses: The way at every `dt`, shape (T, 3).
        speed: The speed at the start, m/s.
        step: The time step that is asked about.
        brake: Its deceleration, m/s2.
        dt: Length of a time step, seconds.
        pose: The array that takes the pose, shape (3,).
    """
    time = min(step * dt, speed / brake)
    # Unbraked, it would be as far after so many time steps.
    steps = (time - brake * time * time / (2 * speed)) / dt
    before = min(int(steps), len(poses) - 1)
    after = min(before + 1, len(poses) - 1)
    for k in range(3):
        pose[k] = poses[before, k] + (steps - before) * (poses[after, k] - poses[before, k])


@kernel(nogil=True)
def _may_touch(
    before: Floats,
    after: Floats,
    now: Floats,
    then: Floats,
    half: Floats,
    own: tuple[float, float],
) -> bool:
    """Whether a vehicle and a rectangle may touch from one time step to the next.

    Args:
        before: The vehicle's state x, y, velocity, heading, ... at the first.
        after: The vehicle's state at the second.
        now: Pose of the rectangle at the first.
        then: Pose of the rectangle at the second.
        half: Half the length and width of the rectangle.
        own: Half the length and width of the vehicle.
    """
    # Their circles: between two steps centres are never nearer than in the middle, less half a way.
    radius = np.hypot(own[0], own[1])
    x1, y1, x2, y2 = before[0] - now[0], before[1] - now[1], after[0] - then[0], after[1] - then[1]
    way = np.hypot(x2 - x1, y2 - y1)
    reach = np.hypot(half[0], half[1]) + radius + TOLERANCE
    if np.hypot(x1 + x2, y1 + y2) / 2 - way / 2 > reach:
        return False
    # What a corner may leave the straight line by between the two steps (`swept_contact`).
    own_turn, turn = wrapped(after[3] - before[3]), wrapped(then[2] - now[2])
    farthest = np.hypot(x1, y1) + way
    lacking = turn**2 * farthest + 2 * abs(turn) * way + radius * (own_turn - turn) ** 2
    margin = lacking / 8 + TOLERANCE
    # The vehicle's extent in the rectangle's frame, at both steps.
    # Invariant: low and high bound the vehicle's extents at the steps so far.
    low_x, high_x, low_y, high_y = np.inf, -np.inf, np.inf, -np.inf
    for x, y, heading, facing in (
        (x1, y1, before[3], now[2]),
        (x2, y2, before[3] + own_turn, now[2] + turn),
    ):
        cos, sin = np.cos(facing), np.sin(facing)
        along, across = cos * x + sin * y, cos * y - sin * x
        c, s = abs(np.cos(heading - facing)), abs(np.sin(heading - facing))
        extent_x, extent_y = c * own[0] + s * own[1], s * own[0] + c * own[1]
        low_x, high_x = min(low_x, along - extent_x), max(high_x, along + extent_x)
        low_y, high_y = min(low_y, across - extent_y), max(high_y, across + extent_y)
    margin_x, margin_y = half[0] + margin, half[1] + margin
    return bool(
        high_x >= -margin_x and low_x <= margin_x and high_y >= -margin_y and low_y <= margin_y
    )
