"""Mouths of side streets: flat, with rounded kerbs."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import ArrayLike
from shapely.geometry.base import BaseGeometry

from avsec_gym.geometry import Floats
from avsec_gym.world.section import CrossSection, Strip
from avsec_gym.world.site import SideStreet, Site

_KERB = 0.14
"""Width of a kerb stone, metres."""
_STEP = 0.02
"""Metres; what is lower is level with the carriageway."""
_REACH = 60.0
"""How much of the main road a side street looks at, either way, metres."""


class Mouth(NamedTuple):
    """Where a side street opens, in the main road's coordinates."""

    street: SideStreet
    paved: BaseGeometry
    """Level with the carriageway, from its edge to a little way up the side street."""
    kerb: BaseGeometry
    """Rounded kerb stones beside it; empty where there are none."""
    steps: BaseGeometry
    """Lines along which the kerb stands above the paved area, which lies on their right."""
    height: float
    """Height of the kerb."""

    @property
    def area(self) -> BaseGeometry:
        """What the main road's strips leave out."""
        return shapely.union(self.paved, self.kerb)

    @property
    def opening(self) -> BaseGeometry:
        """Where no upright face stands, its edges included."""
        return self.paved.buffer(0.005)


def mouths(site: Site, start: float, end: float) -> list[Mouth]:
    """Those between two road coordinates."""
    return [_mouth(site, street) for street in site.side_streets if start < street.along < end]


def road_height(site: Site, along: ArrayLike, left: ArrayLike) -> Floats:
    """Height above the ground at places of the main road: its section's, 0 in mouths."""
    along, left = np.broadcast_arrays(np.asarray(along, float), np.asarray(left, float))
    height = site.section.height(left)
    for mouth in mouths(site, -np.inf, np.inf):
        inside = shapely.contains_xy(mouth.paved, along, left)
        height = np.where(inside, 0.0, height)
    return height


def left_out(site: Site, mouth: Mouth, area: BaseGeometry) -> BaseGeometry:
    """An area of the main road's coordinates, and all of that road, in the side street's."""
    right, left = site.section.edges
    middle = mouth.street.along
    road = shapely.box(middle - _REACH, right, middle + _REACH, left)
    both = shapely.union(road, area)
    return _moved(both, lambda a, b: to_side(site, mouth.street, a, b))


def to_side(site: Site, street: SideStreet, along: Floats, left: Floats) -> Floats:
    """From the main road's coordinates to the side street's, shape (n, 2)."""
    poses = site.course.poses(along, left)
    return np.stack(street.course.coordinates(poses[:, 0], poses[:, 1]), axis=-1)


def to_main(site: Site, street: SideStreet, along: Floats, left: Floats) -> Floats:
    """From the side street's coordinates to the main road's, shape (n, 2)."""
    poses = street.course.poses(along, left)
    return np.stack(site.course.coordinates(poses[:, 0], poses[:, 1]), axis=-1)


@functools.lru_cache(maxsize=64)
def _mouth(site: Site, street: SideStreet) -> Mouth:
    # The street's carriageway, in the main road's coordinates.
    side, radius = street.side, street.radius
    road_edge = _edge(site.section.carriageway, side)
    kerb_edge, height = _kerb_line(site.section, side)
    outer = _edge(site.section.edges, side)
    depth = side * (outer - kerb_edge) + radius + 2.0
    lane_right, lane_left = street.section.carriageway
    length = 2.0 * (side * outer + depth)
    lane = shapely.box(0.0, lane_right, length, lane_left)
    lane = _moved(lane, lambda a, b: to_main(site, street, a, b))

    def beyond(width: float, extent: float) -> BaseGeometry:
        levels = sorted([kerb_edge, kerb_edge + side * extent])
        return shapely.box(street.along - width, levels[0], street.along + width, levels[1])

    # What is not lane, its corners rounded off: the rest is the mouth.
    width = 0.5 * (lane_left - lane_right) + 2.0 * radius + depth
    land = shapely.difference(beyond(2.0 * width, 2.0 * depth), lane)
    rounded = land.buffer(-radius, quad_segs=12).buffer(radius, quad_segs=12)
    # Shrunk and grown again: without the slivers that rounding leaves along straight edges.
    paved = shapely.difference(beyond(width, depth), rounded)
    paved = paved.buffer(-0.005, join_style="mitre").buffer(0.005, join_style="mitre")
    paved = shapely.simplify(paved, 0.002)
    # Between the carriageway and a kerb farther out, the mouth goes on.
    if side * (kerb_edge - road_edge) > 0.02:
        first, _, last, _ = shapely.intersection(paved, beyond(width, 0.05)).bounds
        low, high = sorted([road_edge, kerb_edge + side * 0.01])
        paved = shapely.union(paved, shapely.box(first, low, last, high))
    # Kerb stones and their upright faces stand where the mouth meets raised ground.
    main = [
        shapely.box(street.along - _REACH, strip.right, street.along + _REACH, strip.left)
        for strip in _raised(site.section)
    ]
    others = [
        _moved(
            shapely.box(0.0, strip.right, length, strip.left),
            lambda a, b: to_main(site, street, a, b),
        )
        for strip in _raised(street.section)
    ]
    nearby = shapely.intersection(
        shapely.union_all([*main, *others]), beyond(2.0 * width, 2.0 * depth)
    )
    raised = shapely.difference(nearby, paved)
    kerb = shapely.intersection(shapely.difference(paved.buffer(_KERB), paved), raised)
    ring = shapely.orient_polygons(paved, exterior_cw=True).exterior
    steps = shapely.intersection(ring, raised.buffer(0.01))
    return Mouth(street, paved, kerb, steps, height)


def _kerb_line(section: CrossSection, side: int) -> tuple[float, float]:
    """The first step upwards beside the carriageway and its height, or the edge and 0."""
    edge = _edge(section.carriageway, side)
    for strip in section.strips[::side]:
        inner = strip.right if side > 0 else strip.left
        if side * (inner - edge) > -1e-6 and strip.height > _STEP:
            return inner, strip.height
    return edge, 0.0


def _raised(section: CrossSection) -> list[Strip]:
    return [strip for strip in section.strips if strip.height > _STEP]


def _edge(edges: tuple[float, float], side: int) -> float:
    return edges[1] if side > 0 else edges[0]


def _moved(area: BaseGeometry, move: Callable[[Floats, Floats], Floats]) -> BaseGeometry:
    """In other coordinates, its lines broken up so that they may bend."""
    fine = shapely.segmentize(area, 1.0)
    return shapely.make_valid(
        shapely.transform(fine, lambda points: move(points[:, 0], points[:, 1]))
    )
