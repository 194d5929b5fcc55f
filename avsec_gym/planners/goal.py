"""Goal regions for the search kernel, and how long believed objects leave no room in them."""

from __future__ import annotations

from functools import lru_cache

import numba
import numpy as np
import shapely

from avsec_gym.errors import PlanningError
from avsec_gym.geometry import Floats
from avsec_gym.planners.collision import World, collides
from avsec_gym.planners.search import GoalArrays
from avsec_gym.planners.vehicle import Vehicle
from avsec_gym.scenario.planning_scenario import Goal
from avsec_gym.scenario.shapes import Disc, Shape

_SPACING = 0.25
"""Metres between the places that are tried when a goal region is searched for room."""
_HEADINGS = 5


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
        boxes=np.array([_box(goal.region) for goal in goals]),
        aim=_aim(goals[0]),
    )


def occupied_steps(goals: tuple[Goal, ...], world: World, vehicle: Vehicle) -> int:
    """Time steps of the goals' windows in which the vehicle fits nowhere in a goal region.

    Places are tried on a grid of 0.25 m and five headings, so a shorter gap counts as none.

    Returns:
        A number of steps; 0 where a goal asks for no region.
    """
    if any(goal.region is None for goal in goals):
        return 0
    places = _places(goals)
    first, last = min(goal.steps[0] for goal in goals), max(goal.steps[1] for goal in goals)
    standing = bool(world.static.all())
    full = _full_steps(
        places, world, vehicle.length / 2, vehicle.width / 2, first, first if standing else last
    )
    return full * (last - first + 1) if standing else full


@lru_cache(maxsize=256)
def _places(goals: tuple[Goal, ...]) -> Floats:
    """Poses to try in the goal regions, shape (M, 3)."""
    poses = []
    for goal in goals:
        x1, x2, y1, y2 = _box(goal.region)
        x = np.linspace(x1, x2, max(2, int(np.ceil((x2 - x1) / _SPACING)) + 1))
        y = np.linspace(y1, y2, max(2, int(np.ceil((y2 - y1) / _SPACING)) + 1))
        grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        area = shapely.union_all([shape.polygon() for shape in goal.region or ()])
        inside = grid[shapely.intersects_xy(area.buffer(1e-9), grid[:, 0], grid[:, 1])]
        low, high = goal.heading or (0.0, 2 * np.pi)
        for heading in np.linspace(low, high, _HEADINGS):
            poses.append(np.column_stack([inside, np.full(len(inside), heading)]))
    # The middle heading is the likeliest to fit.
    return np.vstack(sorted(poses, key=lambda block: abs(block[0, 2]) if len(block) else 0.0))


@numba.njit(nogil=True, cache=True)
def _full_steps(
    places: Floats, world: World, half_length: float, half_width: float, first: int, last: int
) -> int:
    full = 0
    for step in range(first, last + 1):
        room = False
        for p in range(places.shape[0]):
            cos, sin = np.cos(places[p, 2]), np.sin(places[p, 2])
            if not collides(
                places[p, 0], places[p, 1], cos, sin, half_length, half_width, step, world
            ):
                room = True
                break
        if not room:
            full += 1
    return full


def _box(region: tuple[Shape, ...] | None) -> tuple[float, float, float, float]:
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
        return np.array(_box(goal.region))
    centre = first.polygon().centroid
    return np.array([centre.x, centre.x, centre.y, centre.y])
