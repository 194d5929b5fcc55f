"""The land beside a road: what may stand where, and what stands there."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial

import numpy as np
import shapely

from avsec_gym.geometry import rectangle_polygons
from avsec_gym.world.assets import draw_variant, part_of
from avsec_gym.world.mesh import Mesh
from avsec_gym.world.section import Surface
from avsec_gym.world.site import Site

Make = Callable[[float], Mesh]
"""Makes a mesh for a distance to the camera, metres: what is far may be coarse."""


@dataclass(frozen=True, eq=False)
class Placement:
    """Something that stands somewhere for good.

    Args:
        make: The mesh in its own frame.
        surface: Surface class of the mesh.
        x: Place in the world, metres.
        y: Place in the world, metres.
        z: Height of its foot, metres.
        yaw: Rotation about the vertical, radians.
        scale: Scale of the mesh.
        reach: Distance from its place to its farthest part, metres.
    """

    make: Make
    surface: Surface
    x: float
    y: float
    z: float
    yaw: float
    scale: float = 1.0
    reach: float = 5.0

    def mesh(self, distance: float) -> Mesh:
        """In the world frame, for a camera at a distance in metres."""
        mesh = self.make(distance)
        if self.scale != 1.0:
            mesh = mesh.scaled(self.scale, self.scale, self.scale)
        return mesh.placed(self.x, self.y, self.z, self.yaw)


class Plot:
    """Collects placements that stand clear of roads, actors, lines of sight and one another.

    Args:
        site: The place.
        start: Road coordinate along the main course at which the plot begins, metres.
        end: Road coordinate at which it ends, metres.
        keep_clear: Areas where nothing may stand, in the world's ground plane.
    """

    def __init__(
        self, site: Site, start: float, end: float, keep_clear: Iterable[shapely.Geometry] = ()
    ) -> None:
        self.site, self.start, self.end = site, start, end
        self.part = part_of(site.seed)
        self.placements: list[Placement] = []
        mouths = [
            _ribbon(street.course, *_widened(street.section.edges, street.radius * 0.5))
            for street in site.side_streets
        ]
        self._closed = shapely.union_all([*keep_clear, *mouths])
        driven = [
            (strip.right, strip.left)
            for strip in site.section.strips
            if strip.surface in (Surface.ROAD, Surface.PARKING, Surface.CYCLE_PATH)
        ]
        self._driven = shapely.union_all(
            [_ribbon(site.course, *across, start, end) for across in driven]
        )
        self._road = _ribbon(site.course, *site.section.edges, start, end)
        for area in (self._closed, self._driven, self._road):
            shapely.prepare(area)
        self._taken: list[shapely.Polygon] = []
        self._bounds = np.empty((256, 4))

    def draw(self, rng: np.random.Generator, family: str, count: int) -> int:
        """A variant of a family of assets that belongs to the place's part."""
        return draw_variant(rng, family, count, self.part)

    def height(self, along: float, left: float) -> float:
        """Of the ground (or pavement) at road coordinates, metres."""
        x, y, _ = self.site.course.poses(along, left)
        section = float(self.site.section.height(left))
        return float(self.site.ground.height(x, y)) + section

    def kerb(self, side: int) -> float:
        """Distance from the course at which a pavement or verge begins.

        It begins beyond parked cars, and beyond a cycle path that runs beside them.
        """
        strips = self.site.section.strips[::side]
        driven = (Surface.ROAD, Surface.PARKING, Surface.KERB)
        last = max(number for number, strip in enumerate(strips) if strip.surface in driven)
        beyond = [s for s in strips[last + 1 :] if s.surface != Surface.CYCLE_PATH]
        if not beyond:
            return abs(self.site.section.edges[1 if side > 0 else 0])
        return abs(beyond[0].right if side > 0 else beyond[0].left)

    def place(
        self,
        make: Make | Mesh,
        surface: Surface,
        along: float,
        left: float,
        *,
        heading: float = 0.0,
        size: tuple[float, float] = (0.5, 0.5),
        offset: float = 0.0,
        scale: float = 1.0,
        on_road: bool = False,
        sunk: float = 0.0,
    ) -> bool:
        """Put something beside the road, if it has room.

        Args:
            make: Mesh, or what makes it.
            surface: Surface class of the mesh.
            along: Road coordinate of its origin, metres.
            left: Distance of its origin to the left of the course, metres.
            heading: Heading relative to the road's direction there, radians.
            size: Size of its footprint on the ground along its x and y axes, metres.
            offset: Offset of the footprint's centre from the origin, along its y axis, metres.
            scale: Scale of the mesh.
            on_road: Whether it may stand on pavements and verges (never where vehicles drive, park
                or cycle).
            sunk: Lower its foot, metres.

        Returns:
            Whether it had room.
        """
        x, y, yaw = (float(value) for value in self.site.course.poses(along, left, heading))
        centre = (x - offset * np.sin(yaw), y + offset * np.cos(yaw), yaw)
        footprint = rectangle_polygons(np.array(centre), size[0] * scale, size[1] * scale).item()
        road = self._driven if on_road else self._road
        if shapely.intersects(self._closed, footprint) or shapely.intersects(road, footprint):
            return False
        if any(shapely.intersects(other, footprint) for other in self._near(footprint)):
            return False
        self.reserve(footprint)
        corners = shapely.get_coordinates(footprint)[:4]
        base = float(self.site.ground.height(*corners.T).min())
        base = self.height(along, left) if max(size) < 3.0 else base
        reach = float(np.hypot(*size)) * scale + abs(offset)
        self._add(make, surface, x, y, base - sunk, yaw, scale, reach)
        return True

    def reserve(self, area: shapely.Polygon) -> None:
        """Let nothing more be placed in an area of the world's ground plane."""
        if len(self._taken) == len(self._bounds):
            self._bounds = np.concatenate([self._bounds, self._bounds])
        self._bounds[len(self._taken)] = shapely.bounds(area)
        self._taken.append(area)

    def add(self, mesh: Mesh, surface: Surface, middle: tuple[float, float], reach: float) -> None:
        """Add what is already in the world frame and needs no room: rails, fences, backdrops."""
        self.placements.append(
            Placement(lambda _: mesh, surface, 0.0, 0.0, 0.0, 0.0, 1.0, reach)
            if reach == np.inf
            else Placement(
                partial(_shifted, mesh, -middle[0], -middle[1]),
                surface,
                *middle,
                0.0,
                0.0,
                1.0,
                reach,
            )
        )

    def _add(
        self,
        make: Make | Mesh,
        surface: Surface,
        x: float,
        y: float,
        z: float,
        yaw: float,
        scale: float,
        reach: float,
    ) -> None:
        if isinstance(make, Mesh):
            make = partial(_same, make)
        self.placements.append(Placement(make, surface, x, y, z, yaw, scale, reach))

    def _near(self, footprint: shapely.Polygon) -> list[shapely.Polygon]:
        low_x, low_y, high_x, high_y = shapely.bounds(footprint)
        bounds = self._bounds[: len(self._taken)]
        close = (bounds[:, 0] <= high_x) & (bounds[:, 2] >= low_x)
        close &= (bounds[:, 1] <= high_y) & (bounds[:, 3] >= low_y)
        return [self._taken[index] for index in np.flatnonzero(close)]


def _same(mesh: Mesh, distance: float) -> Mesh:
    return mesh


def _shifted(mesh: Mesh, x: float, y: float, distance: float) -> Mesh:
    return mesh.placed(x, y)


def _widened(edges: tuple[float, float], margin: float) -> tuple[float, float]:
    return edges[0] - margin, edges[1] + margin


def _ribbon(course, right, left, start=None, end=None) -> shapely.Polygon:  # type: ignore[no-untyped-def]
    """The area of a road between two offsets."""
    along = np.arange(
        course.start if start is None else start, (course.end if end is None else end) + 1.0, 2.0
    )
    one, two = course.poses(along, right)[:, :2], course.poses(along, left)[:, :2]
    return shapely.buffer(shapely.Polygon(np.concatenate([one, two[::-1]])), 0)
