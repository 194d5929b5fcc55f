"""Mouths of side streets: flat, with rounded kerbs."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import ArrayLike
from shapely.geometry.base import BaseGeometry

from avsec_gym.geometry import Floats
from avsec_gym.world.road.section import CrossSection, Strip, Surface
from avsec_gym.world.site import SideStreet, Site

_KERB = 0.14
"""Width of a kerb stone, metres."""
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
    """Of the kerb."""

    @property
    def area(self) -> BaseGeometry:
        """What the main road's strips leave out."""
        return shapely.union(self.paved, self.kerb)


def mouths(site: Site, start: float, end: float) -> list[Mouth]:
    """Those between two road coordinates."""
    return [_mouth(site, street) for street in site.side_streets if start < street.along < end]


def road_height(site: Site, along: ArrayLike, left: ArrayLike) -> Floats:
    """Height above the ground at places of the main road: as its section says, 0 in mouths."""
    along, left = np.broadcast_arrays(np.asarray(along, float), np.asarray(left, float))
    height = site.section.height(left)
    for mouth in mouths(site, -np.inf, np.inf):
        inside = shapely.contains_xy(mouth.paved, along, left)
        height = np.where(inside, 0.0, height)
    return height


def left_out(site: Site, mouth: Mouth) -> BaseGeometry:
    """What the side street's own strips leave out, in its coordinates."""
    right, left = site.section.edges
    middle = mouth.street.along
    road = shapely.box(middle - _REACH, right, middle + _REACH, left)
    both = shapely.union(road, mouth.area)
    return _moved(both, lambda a, b: to_side(site, mouth.street, a, b))


def to_side(site: Site, street: SideStreet, along: Floats, left: Floats) -> Floats:
    """From the main road's coordinates to the side street's, shape (n, 2)."""
    poses = site.course.poses(along, left)
    return np.stack(street.course.coordinates(poses[:, 0], poses[:, 1]), axis=-1)


def to_main(site: Site, street: SideStreet, along: Floats, left: Floats) -> Floats:
    """From the side street's coordinates to the main road's, shape (n, 2)."""
    poses = street.course.poses(along, left)
    return np.stack(site.course.coordinates(poses[:, 0], poses[:, 1]), axis=-1)


def _mouth(site: Site, street: SideStreet) -> Mouth:
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
    opening = shapely.difference(beyond(width, depth), rounded).buffer(-0.005).buffer(0.005)
    first, _, last, _ = shapely.intersection(opening, beyond(width, 0.05)).bounds
    front = shapely.box(first, *sorted([road_edge, kerb_edge + side * 0.01])[:1], last, max(road_edge, kerb_edge + side * 0.01))
    paved = shapely.union(opening, front) if abs(kerb_edge - road_edge) > 0.02 else opening
    raised = shapely.union_all(
        [
            *(_strip_box(strip, street.along) for strip in site.section.strips if strip.height > 0.02),
            *(
                _moved(
                    shapely.box(0.0, strip.right, length, strip.left),
                    lambda a, b: to_main(site, street, a, b),
                )
                for strip in street.section.strips
                if strip.height > 0.02
            ),
        ]
    )
    raised = shapely.difference(shapely.intersection(raised, beyond(2 * width, 2 * depth)), paved)
    kerb = shapely.intersection(shapely.difference(paved.buffer(_KERB), paved), raised)
    ring = shapely.orient_polygons(paved, exterior_cw=True).exterior
    steps = shapely.intersection(ring, raised.buffer(0.01))
    return Mouth(street, paved, kerb, steps, height)


def _kerb_line(section: CrossSection, side: int) -> tuple[float, float]:
    """The first step upwards beside the carriageway and its height, or the edge and 0."""
    edge = _edge(section.carriageway, side)
    for strip in section.strips[::side]:
        inner = strip.right if side > 0 else strip.left
        if side * (inner - edge) > -1e-6 and strip.height > 0.02:
            return inner, strip.height
    return edge, 0.0


def _strip_box(strip: Strip, along: float) -> BaseGeometry:
    return shapely.box(along - _REACH, strip.right, along + _REACH, strip.left)


def _edge(edges: tuple[float, float], side: int) -> float:
    return edges[1] if side > 0 else edges[0]


def _moved(area: BaseGeometry, move: Callable[[Floats, Floats], Floats]) -> BaseGeometry:
    """In other coordinates, its lines broken up so that they may bend."""
    fine = shapely.segmentize(area, 1.0)
    return shapely.make_valid(
        shapely.transform(fine, lambda points: move(points[:, 0], points[:, 1]))
    )


__all__ = ["Mouth", "Surface", "left_out", "mouths", "road_height", "to_main", "to_side"]
