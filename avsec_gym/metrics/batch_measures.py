"""Length, cost and clearance of many trajectories at once, for environments that plan in batches.

The same as `path_length`, `sm1_cost` and `smallest_distance` of single ones, for rectangles.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel
from avsec_gym.metrics.collision_check import TrajectoryBatch
from avsec_gym.metrics.trajectory_cost import (
    ACCELERATION,
    HEADING,
    LENGTH,
    SPEED,
    STEERING_ANGLE,
    STEERING_RATE,
    simpson_weights,
)
from avsec_gym.planners.vehicle import Vehicle
from avsec_gym.scenario.planning_scenario import PlanningScenario

_NEVER = 1e6
"""Metres; obstacles that far away fill up the rows of a batch."""


class Measures(NamedTuple):
    """Measures of B trajectories."""

    path_length: Floats
    """m, shape (B,)."""
    smallest_distance: Floats
    """m, 0 where something is touched, infinite where nothing is there, shape (B,)."""
    cost_sm1: Floats
    """Shape (B,)."""


def batch_measures(
    batch: TrajectoryBatch, vehicle: Vehicle, scenario: PlanningScenario
) -> Measures:
    """What trajectories through scenarios of one kind measure.

    Args:
        batch: The trajectories, and what is really there.
        vehicle: The vehicle, of which the size counts.
        scenario: Goal, road and time step, which all share.
    """
    wanted = [goal.velocity[0] for goal in scenario.goals if goal.velocity]
    starts, ends = scenario.road.centre_segments
    measured = _measure(
        *batch,
        (0.5 * vehicle.length, 0.5 * vehicle.width),
        starts.copy(),
        ends.copy(),
        min(wanted) if wanted else np.nan,
        _simpson_table(batch.trajectories.shape[1], scenario.dt),
        scenario.dt,
    )
    return Measures(*measured.T)


@lru_cache(maxsize=64)
def _simpson_table(longest: int, dt: float) -> Floats:
    """Row n: the weights of Simpson's rule for n samples, shape (longest + 1, longest)."""
    table = np.zeros((longest + 1, longest))
    for count in range(longest + 1):
        table[count, :count] = simpson_weights(count, dt)
    return table


@kernel(nogil=True)
def _measure(
    trajectories: Floats,
    lengths: NDArray[np.int64],
    poses: Floats,
    half_sizes: Floats,
    own: tuple[float, float],
    starts: Floats,
    ends: Floats,
    wanted: float,
    simpson: Floats,
    dt: float,
) -> Floats:
    """Path length, smallest distance and SM1 of each, shape (B, 3)."""
    measured = np.empty((trajectories.shape[0], 3))
    moves = poses.shape[2] > 1
    radius = np.hypot(own[0], own[1])
    reaches = np.empty(poses.shape[1])
    along = ends - starts
    squares = along[:, 0] ** 2 + along[:, 1] ** 2
    for b in range(trajectories.shape[0]):
        # How near an obstacle's centre is where the circles around both touch.
        for i in range(poses.shape[1]):
            reaches[i] = radius + np.sqrt(half_sizes[b, i, 0] ** 2 + half_sizes[b, i, 1] ** 2)
        # Invariant: `path` is the length up to state t, `cost` holds the terms of the states and
        # steps before t, and `nearest` is the smallest distance at the states before t.
        path = cost = 0.0
        nearest = np.inf
        count = min(lengths[b], trajectories.shape[1])
        for t in range(count):
            x, y, v, heading, steering = trajectories[b, t]
            # The terms of SM1 at a state, and those between it and the next one.
            off = heading - _lane_heading(x, y, starts, along, squares)
            off = (off + np.pi) % (2.0 * np.pi) - np.pi
            term = STEERING_ANGLE * steering**2 + LENGTH * v + HEADING * off**2
            if not np.isnan(wanted):
                term += SPEED * (wanted - v) ** 2
            cost += term * simpson[count, t]
            if t + 1 < count:
                after = trajectories[b, t + 1]
                path += np.sqrt((after[0] - x) ** 2 + (after[1] - y) ** 2)
                change = ACCELERATION * (after[2] - v) ** 2
                change += STEERING_RATE * (after[4] - steering) ** 2
                cost += change / dt**2 * simpson[count - 1, t]
            # Of the obstacles, only one that may be nearer than all before is looked at closely.
            cos, sin = np.cos(heading), np.sin(heading)
            for i in range(poses.shape[1]):
                k = t if moves else 0
                dx, dy = poses[b, i, k, 0] - x, poses[b, i, k, 1] - y
                reach = reaches[i] + nearest
                if dx * dx + dy * dy >= reach * reach:
                    continue
                # The obstacle in the vehicle's frame, its centre, cosine and sine.
                other_cos, other_sin = poses[b, i, k, 2], poses[b, i, k, 3]
                distance = _rectangle_distance(
                    own,
                    (half_sizes[b, i, 0], half_sizes[b, i, 1]),
                    cos * dx + sin * dy,
                    cos * dy - sin * dx,
                    cos * other_cos + sin * other_sin,
                    cos * other_sin - sin * other_cos,
                )
                nearest = min(nearest, distance)
        measured[b, 0], measured[b, 2] = path, cost
        measured[b, 1] = nearest if nearest < _NEVER else np.inf
    return measured


@kernel(nogil=True)
def _lane_heading(x: float, y: float, starts: Floats, along: Floats, squares: Floats) -> float:
    """Direction of the nearest segment of a lane's centre line, rad; 0 where there is no road.

    Args:
        x: The place, m.
        y: The place, m.
        starts: Where the segments start, shape (K, 2).
        along: Vectors from their starts to their ends, shape (K, 2).
        squares: Squares of their lengths, shape (K,).
    """
    best, nearest = np.inf, -1
    for k in range(starts.shape[0]):
        dx, dy = x - starts[k, 0], y - starts[k, 1]
        share = (dx * along[k, 0] + dy * along[k, 1]) / squares[k]
        share = min(max(share, 0.0), 1.0)
        away = (dx - share * along[k, 0]) ** 2 + (dy - share * along[k, 1]) ** 2
        if away < best:
            best, nearest = away, k
    return float(np.arctan2(along[nearest, 1], along[nearest, 0])) if nearest >= 0 else 0.0


@kernel(nogil=True)
def _rectangle_distance(
    one: tuple[float, float], two: tuple[float, float], x: float, y: float, cos: float, sin: float
) -> float:
    """Distance of two rectangles, m; the second is at x, y and turned, in the first one's frame.

    The nearest points of two convex areas apart from each other are a corner of one and a point of
    the other.  They are apart if a side of either separates them.
    """
    back_x, back_y = cos * x + sin * y, cos * y - sin * x
    apart = (
        abs(x) > one[0] + abs(cos) * two[0] + abs(sin) * two[1]
        or abs(y) > one[1] + abs(sin) * two[0] + abs(cos) * two[1]
        or abs(back_x) > two[0] + abs(cos) * one[0] + abs(sin) * one[1]
        or abs(back_y) > two[1] + abs(sin) * one[0] + abs(cos) * one[1]
    )
    if not apart:
        return 0.0
    nearest = np.inf
    for k in range(4):
        along, across = 1.0 if k in (0, 3) else -1.0, 1.0 if k < 2 else -1.0
        # A corner of the second seen from the first, and the other way round.
        u, v = along * two[0], across * two[1]
        near_x = max(abs(x + cos * u - sin * v) - one[0], 0.0)
        near_y = max(abs(y + sin * u + cos * v) - one[1], 0.0)
        nearest = min(nearest, near_x**2 + near_y**2)
        u, v = along * one[0] - x, across * one[1] - y
        near_x = max(abs(cos * u + sin * v) - two[0], 0.0)
        near_y = max(abs(cos * v - sin * u) - two[1], 0.0)
        nearest = min(nearest, near_x**2 + near_y**2)
    return np.sqrt(nearest)
