"""Goal regions, laid out for the search kernel, and the goal test."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import PlanningError
from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel
from avsec_gym.scenario.planning_scenario import Goal
from avsec_gym.scenario.shapes import Disc, Shape


class GoalArrays(NamedTuple):
    """Goal regions, laid out for the kernel; one row of `vertices` for each convex piece."""

    steps: NDArray[np.int64]
    """First and last time step, shape (G, 2)."""
    intervals: Floats
    """Start of the heading's interval and its width (2 pi or more is any heading), lowest and
    highest velocity, shape (G, 4)."""
    boxes: Floats
    """x_min, x_max, y_min, y_max of each goal's region, infinite where none is asked for, shape
    (G, 4)."""
    vertices: Floats
    """Convex pieces, counter-clockwise, shape (Q, K, 2)."""
    corners: NDArray[np.int64]
    """Goal that each piece belongs to and vertices in use, a single one being a disc, shape
    (Q, 2)."""
    radius: Floats
    """Shape (Q,)."""
    aim: Floats
    """The box that reference mode steers for, shape (4,)."""


@lru_cache(maxsize=1024)
def goal_arrays(goals: tuple[Goal, ...]) -> GoalArrays:
    """Lay goals out for the kernel.

    Raises:
        PlanningError: There is no goal.
    """
    if not goals:
        raise PlanningError("a planning problem needs at least one goal")
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
    velocities = [goal.velocity or (-np.inf, np.inf) for goal in goals]
    return GoalArrays(
        steps=np.array([goal.steps for goal in goals], np.int64),
        intervals=np.array(
            [
                (first, last - first, *velocity)
                for (first, last), velocity in zip(headings, velocities, strict=True)
            ],
            float,
        ),
        boxes=np.array([region_box(goal.region) for goal in goals]),
        vertices=vertices,
        corners=np.array(
            [(g, count) for (g, _), count in zip(pieces, corners, strict=True)], np.int64
        ).reshape(-1, 2),
        radius=np.array([piece.radius for _, piece in pieces]),
        aim=_aim(goals[0]),
    )


@kernel(nogil=True)
def reaches(
    x: float, y: float, heading: float, velocity: float, step: int, goals: GoalArrays
) -> bool:
    """Whether a vehicle with its centre at (x, y) is in a goal region; borders belong to it."""
    for g in range(goals.steps.shape[0]):
        if step < goals.steps[g, 0] or step > goals.steps[g, 1]:
            continue
        interval = goals.intervals[g]
        if velocity < interval[2] or velocity > interval[3]:
            continue
        turned = (heading - interval[0]) % (2.0 * np.pi)
        if turned > interval[1]:
            continue
        if goals.boxes[g, 0] == -np.inf:
            return True
        for q in range(goals.corners.shape[0]):
            if goals.corners[q, 0] == g and _in_piece(
                x, y, goals.vertices, q, goals.corners[q, 1], goals.radius[q]
            ):
                return True
    return False


@kernel(nogil=True)
def _in_piece(x: float, y: float, vertices: Floats, q: int, count: int, radius: float) -> bool:
    """Whether a point is in convex piece q; a piece of a single vertex is a disc."""
    if count == 1:
        dx, dy = x - vertices[q, 0, 0], y - vertices[q, 0, 1]
        return bool(np.sqrt(dx * dx + dy * dy) <= radius)
    for k in range(count):
        following = k + 1 if k + 1 < count else 0
        ax, ay = vertices[q, k, 0], vertices[q, k, 1]
        ex, ey = vertices[q, following, 0] - ax, vertices[q, following, 1] - ay
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
