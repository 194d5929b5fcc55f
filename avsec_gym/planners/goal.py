"""Goal regions, laid out for the search kernel, and the goal test."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import PlanningError
from avsec_gym.geometry import Floats
from avsec_gym.scenario.planning_scenario import Goal
from avsec_gym.scenario.shapes import Disc, Shape


class GoalArrays(NamedTuple):
    """Goal regions, laid out for the kernel; one row of `pieces` for each convex piece."""

    steps: NDArray[np.int64]
    """First and last time step, shape (G, 2)."""
    heading: Floats
    """Start of the interval and its width, shape (G, 2); a width of 2 pi or more is any heading."""
    velocity: Floats
    """Interval, shape (G, 2)."""
    anywhere: NDArray[np.bool_]
    """No region is asked for, shape (G,)."""
    vertices: Floats
    """Convex pieces, counter-clockwise, shape (Q, K, 2)."""
    corners: NDArray[np.int64]
    """Vertices in use, shape (Q,); a single one is a disc."""
    radius: Floats
    """Shape (Q,)."""
    owner: NDArray[np.int64]
    """Goal that each piece belongs to, shape (Q,)."""
    boxes: Floats
    """x_min, x_max, y_min, y_max of each goal's region, shape (G, 4)."""
    aim: Floats
    """The box that reference mode steers for, shape (4,)."""


@lru_cache(maxsize=1024)
def goal_arrays(goals: tuple[Goal, ...]) -> GoalArrays:
    """Lay goals out for the kernel.

    Raises:
        PlanningError: There is no goal, or one that no state can meet.
    """
    if not goals:
        raise PlanningError("a planning problem needs at least one goal")
    for goal in goals:
        if goal.steps[0] > goal.steps[1]:
            raise PlanningError(f"a goal's time window {goal.steps} ends before it begins")
    pieces = [
        (g, piece)
        for g, goal in enumerate(goals)
        for shape in goal.region or ()
        for piece in shape.convex_pieces()
    ]
    corners = np.array([len(piece.vertices) for _, piece in pieces], np.int64)
    vertices = np.zeros((len(pieces), int(corners.max(initial=1)), 2))
    for row, (_, piece) in enumerate(pieces):
        vertices[row, : corners[row]] = piece.vertices
    headings = [goal.heading or (0.0, 2 * np.pi) for goal in goals]
    return GoalArrays(
        steps=np.array([goal.steps for goal in goals], np.int64),
        heading=np.array([(low, high - low) for low, high in headings]),
        velocity=np.array([goal.velocity or (-np.inf, np.inf) for goal in goals], float),
        anywhere=np.array([goal.region is None for goal in goals]),
        vertices=vertices,
        corners=corners,
        radius=np.array([piece.radius for _, piece in pieces]),
        owner=np.array([g for g, _ in pieces], np.int64),
        boxes=np.array([region_box(goal.region) for goal in goals]),
        aim=_aim(goals[0]),
    )


@numba.njit(nogil=True, cache=True)
def reaches(
    x: float, y: float, heading: float, velocity: float, step: int, goals: GoalArrays
) -> bool:
    """Whether a vehicle with its centre at (x, y) is in a goal region; borders belong to it."""
    for g in range(goals.steps.shape[0]):
        if step < goals.steps[g, 0] or step > goals.steps[g, 1]:
            continue
        if velocity < goals.velocity[g, 0] or velocity > goals.velocity[g, 1]:
            continue
        turned = (heading - goals.heading[g, 0]) % (2.0 * np.pi)
        if turned > goals.heading[g, 1]:
            continue
        if goals.anywhere[g]:
            return True
        for q in range(goals.owner.shape[0]):
            if goals.owner[q] == g and _in_piece(x, y, q, goals):
                return True
    return False


@numba.njit(nogil=True, cache=True)
def _in_piece(x: float, y: float, q: int, goals: GoalArrays) -> bool:
    count = goals.corners[q]
    if count == 1:
        dx, dy = x - goals.vertices[q, 0, 0], y - goals.vertices[q, 0, 1]
        return np.sqrt(dx * dx + dy * dy) <= goals.radius[q]
    for k in range(count):
        following = k + 1 if k + 1 < count else 0
        ax, ay = goals.vertices[q, k, 0], goals.vertices[q, k, 1]
        ex, ey = goals.vertices[q, following, 0] - ax, goals.vertices[q, following, 1] - ay
        if ex * (y - ay) - ey * (x - ax) < 0.0:
            return False
    return True


def region_box(region: tuple[Shape, ...] | None) -> tuple[float, float, float, float]:
    """x_min, x_max, y_min, y_max of a region; everything where there is none."""
    if region is None:
        return (-np.inf, np.inf, -np.inf, np.inf)
    points = np.vstack(
        [
            piece.vertices + piece.radius * np.array(corner)
            for shape in region
            for piece in shape.convex_pieces()
            for corner in ((-1.0, -1.0), (1.0, 1.0))
        ]
    )
    (x1, y1), (x2, y2) = points.min(axis=0), points.max(axis=0)
    return (x1, x2, y1, y2)


def _aim(goal: Goal) -> Floats:
    """Where commonroad-search steers for: a single shape's box, else the first shape's centre."""
    if not goal.region:
        return np.zeros(4)
    first = goal.region[0]
    if len(goal.region) == 1 and not isinstance(first, Disc) and not goal.lanelets:
        return np.array(region_box(goal.region))
    centre = first.polygon().centroid
    return np.array([centre.x, centre.x, centre.y, centre.y])
