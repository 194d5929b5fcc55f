"""Parked vehicles: rows on parking strips and on the edges of pavements."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

from avsec_gym.geometry import Floats, rectangle_polygons
from avsec_gym.world.layouts.dimensions import CATEGORIES, CategoryMix
from avsec_gym.world.layouts.road import Placed, join, place_row
from avsec_gym.world.layouts.view import without_overlaps
from avsec_gym.world.section import Strip, Surface
from avsec_gym.world.site import Site
from avsec_gym.world.traffic.population import Bystander
from avsec_gym.world.traffic.routes import Route
from avsec_gym.world.traffic.state import NARROW
from avsec_gym.world.traffic.styles import Bustle

_PARKED = CategoryMix(Car=0.885, Van=0.08, Misc=0.025, Truck=0.01)
_DEEP = 4.0
"""Parking strips from this width on hold bays across the road, metres."""
_UP_THE_KERB = 0.5
"""How far cars that park on a pavement's edge stand in the road at most, metres."""
_ROOM = 0.35
"""Between parked vehicles and the routes of others, metres."""
_ROOM_OF_RIDERS = 0.1


def parked_rows(site: Site, bustle: Bustle, rng: np.random.Generator) -> tuple[Bystander, ...]:
    """Vehicles in rows with lulls; they may still be in the way of routes."""
    strips = site.section.strips
    rows = [
        _row(site, strip, 0.5 * (strip.right + strip.left), bustle, rng)
        for strip in strips
        if strip.surface == Surface.PARKING and rng.random() < 0.95
    ]
    for side in (-1, 1):
        pavement = _at_the_road(strips, side)
        if pavement is not None and rng.random() < bustle.edge_parking:
            edge = site.section.carriageway[0 if side < 0 else 1]
            rows.append(_row(site, pavement, edge + side * (0.83 - _UP_THE_KERB), bustle, rng))
    if not rows or bustle.parked == 0.0:
        return ()
    placed = join(rows)
    placed = placed.pick(_off_mouths(site, placed))
    poses = site.course.poses(placed.along, placed.left, placed.heading)
    apart = without_overlaps(poses, placed.dimensions[:, 2] + 0.3, placed.dimensions[:, 1] + 0.1)
    return tuple(
        Bystander(str(CATEGORIES[code]), tuple(size), tuple(pose))
        for code, size, pose in zip(
            placed.codes[apart],
            placed.dimensions[apart].tolist(),
            poses[apart].tolist(),
            strict=True,
        )
    )


def out_of_the_way(
    bystanders: Sequence[Bystander], routes: Sequence[Route]
) -> tuple[Bystander, ...]:
    """Bystanders that stand on no traveller's route."""
    if not bystanders:
        return ()
    corridors = [
        shapely.LineString(route.poses[::4, :2]).buffer(
            0.5 * route.width + (_ROOM if route.width > NARROW else _ROOM_OF_RIDERS), quad_segs=2
        )
        for route in routes
    ]
    shapes = footprints(bystanders)
    hit = shapely.STRtree(shapes).query(corridors, predicate="intersects")[1]
    blocked = set(hit.tolist())
    return tuple(bystander for index, bystander in enumerate(bystanders) if index not in blocked)


def footprints(bystanders: Sequence[Bystander]) -> np.ndarray:
    """Their outlines as shapely polygons, shape (N,)."""
    poses = np.array([bystander.pose for bystander in bystanders])
    sizes = np.array([bystander.dimensions for bystander in bystanders])
    return rectangle_polygons(poses, sizes[:, 2], sizes[:, 1])


def _row(site: Site, strip: Strip, left: float, bustle: Bustle, rng: np.random.Generator) -> Placed:
    """A row along or, in a deep strip, across the road; full or with lulls, or a short one."""
    side = np.sign(left)
    deep = strip.surface == Surface.PARKING and strip.left - strip.right >= _DEEP
    angle = float(rng.choice([0.5 * np.pi, 0.75, -0.75])) if deep else 0.0
    start, end = site.course.start, site.course.end
    if rng.random() < 0.2:
        start += float(rng.uniform(0.0, 0.6)) * (end - start)
    one_way = len({lane.direction for lane in site.section.lanes}) == 1
    return place_row(
        rng,
        _PARKED,
        start=start,
        end=end - 3.0,
        left=left,
        gap=0.35 if deep else 0.55,
        fullness=float(rng.beta(4.0 * bustle.parked + 0.01, 4.0 * (1.0 - bustle.parked))),
        lull=22.0,
        backwards=0.45 if deep else 0.86 if side > 0 and not one_way else 0.1,
        angle=angle,
        jitter=0.2 if deep else 0.07,
    )


def _off_mouths(site: Site, placed: Placed) -> np.ndarray:
    """Which vehicles leave the mouths of side streets free, shape (N,)."""
    free = np.ones(len(placed.along), bool)
    for street in site.side_streets:
        right, left = street.section.carriageway
        reach = 0.5 * (left - right) + street.radius + 0.5 * placed.dimensions[:, 2]
        beside = np.abs(placed.along - street.along) < reach
        free &= ~(beside & (placed.left * street.side > 0))
    return free


def _at_the_road(strips: Sequence[Strip], side: int) -> Strip | None:
    """A pavement that begins behind the kerb, broad enough to park on its edge."""
    kinds = [strip for strip in strips if strip.surface not in (Surface.KERB, Surface.ROAD)]
    road = [index for index, strip in enumerate(strips) if strip.surface == Surface.ROAD]
    beyond = strips[: road[0]][::-1] if side < 0 else strips[road[-1] + 1 :]
    first = next((strip for strip in beyond if strip in kinds), None)
    if first is None or first.surface != Surface.PAVEMENT or first.left - first.right < 2.0:
        return None
    return first


def poses_of(bystanders: Sequence[Bystander]) -> Floats:
    """Shape (N, 3)."""
    return np.reshape([bystander.pose for bystander in bystanders], (-1, 3))
