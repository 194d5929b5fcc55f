"""The surface of a site's roads as meshes: lanes, kerbs, pavements, side streets."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from avsec_gym.geometry import Floats
from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.road.junction import Mouth, left_out, mouths
from avsec_gym.world.road.loft import Lay, area_meshes, strip_meshes, wall_meshes
from avsec_gym.world.road.materials import ground_materials, strip_material
from avsec_gym.world.section import CrossSection, Surface
from avsec_gym.world.site import Site

PAINTED = (Surface.ROAD, Surface.PARKING, Surface.CYCLE_PATH, Surface.PAVEMENT)
"""Surfaces that show the overlay."""
_STEP = 0.01
"""Metres; a smaller difference of heights needs no upright face."""


def road_meshes(site: Site, start: float, end: float) -> list[tuple[Mesh, Surface]]:
    """All strips of the main road and the side streets that open onto it.

    Heights are those of `site.ground` plus the strips' own ones, but 0 in the mouths of side
    streets (`avsec_gym.world.road.junction.road_height`).  Painted surfaces of the main road
    carry `Mesh.overlay_uv`: metres from the upper left corner of the overlay that
    `avsec_gym.world.road.overlay.paint_overlay` draws for the same start and end.

    Args:
        site: The place; its materials depend on its seed.
        start: Road coordinate at which the road begins, metres.
        end: Road coordinate at which it ends, metres.

    Returns:
        One mesh for each kind of surface.
    """
    # The main road's strips, with holes where side streets open.
    materials = ground_materials(site)
    openings = mouths(site, start, end)
    holes = tuple(
        shapely.union_all(areas)
        for areas in ([m.area for m in openings], [m.opening for m in openings])
    )
    stations = _stations(start, end)
    plain = Lay(site.course, site.ground)
    painted = plain._replace(overlay_corner=(start, painted_edges(site.section)[1]))
    parts = _section_meshes(painted, site.section, stations, materials, holes)
    # The mouths, their kerbs, and the side streets behind them.
    lanes = [strip for strip in site.section.strips if strip.surface == Surface.ROAD]
    widest = max(lanes, key=lambda strip: strip.left - strip.right)
    for mouth in openings:
        road = strip_material(materials, widest)
        parts += [(m, Surface.ROAD) for m in area_meshes(painted, mouth.paved, 0.0, road)]
        kerb = materials["kerb"]
        stones = area_meshes(plain, mouth.kerb, mouth.height, kerb)
        stones += wall_meshes(plain, mouth.steps, 0.0, mouth.height, kerb)
        parts += [(stone, Surface.KERB) for stone in stones]
        parts += _side_meshes(site, mouth, materials)
    kinds = sorted({surface for _, surface in parts})
    return [(merge([mesh for mesh, surface in parts if surface == kind]), kind) for kind in kinds]


def painted_edges(section: CrossSection) -> tuple[float, float]:
    """Right and left end of what the overlay covers, metres to the left of the course."""
    strips = [strip for strip in section.strips if strip.surface in PAINTED]
    return strips[0].right, strips[-1].left


def outline(site: Site, start: float, end: float) -> BaseGeometry:
    """All that the road's meshes cover, in the world frame: the land leaves it out."""
    stations = _stations(start, end)
    areas = [_corridor(Lay(site.course, site.ground), stations, site.section)]
    for mouth in mouths(site, start, end):
        street = mouth.street
        rows = _stations(0.0, street.course.end)
        areas.append(_corridor(Lay(street.course, site.ground), rows, street.section))
        areas.append(
            shapely.transform(
                shapely.segmentize(mouth.area, 1.0),
                lambda points: site.course.poses(points[:, 0], points[:, 1])[:, :2],
            )
        )
    # A mouth laid along a bending road may touch itself.
    return shapely.union_all(shapely.make_valid(areas), grid_size=1e-4)


def _side_meshes(
    site: Site, mouth: Mouth, materials: dict[str, Material]
) -> list[tuple[Mesh, Surface]]:
    lay = Lay(mouth.street.course, site.ground)
    stations = _stations(0.0, mouth.street.course.end)
    holes = tuple(left_out(site, mouth, area) for area in (mouth.area, mouth.opening))
    return _section_meshes(lay, mouth.street.section, stations, materials, holes)


def _section_meshes(
    lay: Lay,
    section: CrossSection,
    stations: Floats,
    materials: dict[str, Material],
    holes: tuple[BaseGeometry, ...],
) -> list[tuple[Mesh, Surface]]:
    """All strips of a section and the faces between them; the holes of strips and of faces."""
    parts = []
    for strip in section.strips:
        shown = lay if strip.surface in PAINTED else lay._replace(overlay_corner=None)
        meshes = strip_meshes(
            shown,
            stations,
            (strip.right, strip.left),
            strip.height,
            strip_material(materials, strip),
            holes[0],
        )
        parts += [(mesh, strip.surface) for mesh in meshes]
    # Upright faces between strips of different height, and at the outer edges.
    heights = [0.0, *(strip.height for strip in section.strips), 0.0]
    borders = [section.edges[0], *(strip.left for strip in section.strips)]
    for border, (right, left) in zip(borders, pairwise(heights), strict=True):
        if abs(right - left) < _STEP:
            continue
        along = stations if left > right else stations[::-1]
        line = shapely.linestrings(np.stack([along, np.full_like(along, border)], axis=-1))
        faces = wall_meshes(
            lay._replace(overlay_corner=None),
            shapely.difference(line, holes[1]),
            min(right, left),
            max(right, left),
            materials["kerb"],
        )
        parts += [(face, Surface.KERB) for face in faces]
    return parts


def _corridor(lay: Lay, stations: Floats, section: CrossSection) -> BaseGeometry:
    """A section's whole width, in the world frame."""
    right, left = section.edges
    near = lay.course.poses(stations, right)[:, :2]
    far = lay.course.poses(stations, left)[:, :2]
    return shapely.make_valid(shapely.Polygon(np.concatenate([near, far[::-1]])))


def _stations(start: float, end: float) -> Floats:
    return np.linspace(start, end, max(2, int(np.ceil(end - start - 1e-9)) + 1))
