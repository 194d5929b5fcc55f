"""How long believed objects leave no room in the goal region, tried and proven."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
import shapely

from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel
from avsec_gym.planners.collision import CollisionWorld, collides
from avsec_gym.planners.goal import region_box
from avsec_gym.planners.vehicle import Vehicle
from avsec_gym.scenario.planning_scenario import Goal
from avsec_gym.scenario.shapes import Shape

_SPACING = 0.25
"""Metres between the places that are tried, and the side of the cells of the proof; wider in
regions that would have more than `_MOST` of them."""
_MOST = 100_000
_HEADINGS = 5
_SWING = 0.25
"""Metres by which a corner may move where the proof takes two headings for one."""


def occupied_steps(goals: tuple[Goal, ...], world: CollisionWorld, vehicle: Vehicle) -> int:
    """Time steps of the goals' windows in which the vehicle fits nowhere in a goal region.

    Places are tried on a grid of 0.25 m and five headings, so a shorter gap counts as none.

    Returns:
        A number of steps; 0 where a goal asks for no region.
    """
    if any(goal.region is None for goal in goals):
        return 0
    places = _places(goals)
    first, last = min(goal.steps[0] for goal in goals), max(goal.steps[1] for goal in goals)
    standing = world.standing
    until = first if standing else last
    half_length, half_width = vehicle.length / 2, vehicle.width / 2
    full = _full_steps(places, world, half_length, half_width, first, until, False)
    return full * (last - first + 1) if standing else full


def is_full(goals: tuple[Goal, ...], world: CollisionWorld, vehicle: Vehicle) -> bool:
    """Whether the vehicle is proven to fit in no goal region at any time that its goal allows.

    The region is covered with cells of positions and headings.  A rectangle that is smaller by as
    much as the vehicle can move within a cell is part of the vehicle wherever in the cell it
    stands: where that touches something, so does the vehicle.

    Args:
        goals: The goals; one without a region is never full.
        world: The obstacles and the road edge.
        vehicle: The vehicle, whose size counts.
    """
    radius = float(np.hypot(vehicle.length, vehicle.width)) / 2
    # Cells of positions and headings over each region, and how far a corner moves in one.
    for goal in goals:
        if goal.region is None:
            return False
        low, high = goal.heading or (0.0, 2 * np.pi)
        count = max(1, int(np.ceil((high - low) * radius / (2 * _SWING))))
        headings = low + (np.arange(count) + 0.5) * (high - low) / count
        cells, spacing = _cells(goal.region)
        margin = spacing / np.sqrt(2) + radius * (high - low) / (2 * count) + 1e-9
        half_length, half_width = vehicle.length / 2 - margin, vehicle.width / 2 - margin
        if half_width <= 0:
            return False
        places = np.column_stack([np.tile(cells, (count, 1)), headings.repeat(len(cells))])
        first, last = goal.steps
        last = first if world.standing else last
        full = _full_steps(places, world, half_length, half_width, first, last, True)
        if full <= last - first:
            return False
    return True


@lru_cache(maxsize=256)
def _places(goals: tuple[Goal, ...]) -> Floats:
    """Poses to try in the goal regions, shape (M, 3)."""
    poses: list[Floats] = []
    for goal in goals:
        grid, _ = _grid(goal.region or ())
        area = shapely.union_all([shape.polygon() for shape in goal.region or ()])
        inside = grid[shapely.intersects_xy(area.buffer(1e-9), grid[:, 0], grid[:, 1])]
        low, high = goal.heading or (0.0, 2 * np.pi)
        # The middle heading is the likeliest to fit: it comes first.
        headings = np.linspace(low, high, _HEADINGS)
        for heading in headings[np.argsort(np.abs(headings - headings.mean()), kind="stable")]:
            poses.append(np.column_stack([inside, np.full(len(inside), heading)]))
    return np.vstack(poses)


@lru_cache(maxsize=256)
def _cells(region: tuple[Shape, ...]) -> tuple[Floats, float]:
    """Centres of square cells that cover a region, shape (M, 2), and their side."""
    grid, spacing = _grid(region)
    area = shapely.union_all([shape.polygon() for shape in region]).buffer(spacing)
    return grid[shapely.intersects_xy(area, grid[:, 0], grid[:, 1])], spacing


def _grid(region: tuple[Shape, ...]) -> tuple[Floats, float]:
    """Points over a region's box, from border to border, and their largest distance."""
    x1, x2, y1, y2 = region_box(region)
    length, width = float(x2 - x1), float(y2 - y1)
    spacing = max(_SPACING, math.sqrt(length * width / _MOST), (length + width) / _MOST)
    x = np.linspace(x1, x2, max(2, int(np.ceil((x2 - x1) / spacing)) + 1))
    y = np.linspace(y1, y2, max(2, int(np.ceil((y2 - y1) / spacing)) + 1))
    return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2), spacing


@kernel(nogil=True)
def _full_steps(
    places: Floats,
    world: CollisionWorld,
    half_length: float,
    half_width: float,
    first: int,
    last: int,
    all_or_none: bool,
) -> int:
    """Time steps at which all places collide; counted up to one that does not, where asked."""
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
        elif all_or_none:
            break
    return full
