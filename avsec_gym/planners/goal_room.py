"""How long believed objects leave no room in the goal region."""

from __future__ import annotations

from functools import lru_cache

import numba
import numpy as np
import shapely

from avsec_gym.geometry import Floats
from avsec_gym.planners.collision import World, collides
from avsec_gym.planners.goal import region_box
from avsec_gym.planners.vehicle import Vehicle
from avsec_gym.scenario.planning_scenario import Goal

_SPACING = 0.25
"""Metres between the places that are tried."""
_HEADINGS = 5


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
    poses: list[Floats] = []
    for goal in goals:
        x1, x2, y1, y2 = region_box(goal.region)
        x = np.linspace(x1, x2, max(2, int(np.ceil((x2 - x1) / _SPACING)) + 1))
        y = np.linspace(y1, y2, max(2, int(np.ceil((y2 - y1) / _SPACING)) + 1))
        grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        area = shapely.union_all([shape.polygon() for shape in goal.region or ()])
        inside = grid[shapely.intersects_xy(area.buffer(1e-9), grid[:, 0], grid[:, 1])]
        low, high = goal.heading or (0.0, 2 * np.pi)
        # The middle heading is the likeliest to fit: it comes first.
        headings = np.linspace(low, high, _HEADINGS)
        for heading in headings[np.argsort(np.abs(headings - headings.mean()), kind="stable")]:
            poses.append(np.column_stack([inside, np.full(len(inside), heading)]))
    return np.vstack(poses)


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
