"""Open land around the roads, as far as the eye sees."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from avsec_gym.geometry import Floats, rectangle_polygons
from avsec_gym.world.ground import EASE
from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.road.loft import ground_normals, triangles
from avsec_gym.world.road.materials import ground_materials
from avsec_gym.world.road.surface import outline
from avsec_gym.world.section import Surface
from avsec_gym.world.site import Site, Style

_REACH = 900.0
"""Metres beyond the roads."""
_MARGIN = 40.0
"""Around the roads the land is as fine as there."""
_CELLS = 9_000
"""The size of the grid: at most about so many of the finest cells."""
_GROWTH = 1.35
_SMALL_SWELL = 12.0
"""Metres; larger ones are even enough for the lattice."""
_NEAR = {
    Style.CITY: ("footway", "cobbles", "asphalt"),
    Style.RESIDENTIAL: ("grass", "grass", "soil"),
    Style.CAMPUS: ("grass", "grass", "leaves"),
    Style.HIGHWAY: ("grass", "grass", "grass"),
    Style.RURAL: ("grass", "grass", "grass"),
}
"""Mostly the first, here and there the others."""
_GREENS = ((0.92, 1.0, 0.9), (1.06, 1.0, 0.95), (0.8, 0.86, 0.8))
"""Tints of meadows."""


def land_mesh(site: Site, start: float, end: float, rng: np.random.Generator) -> Mesh:
    """The ground beside the roads, cut out where they run.

    Args:
        site: The place.
        start: Road coordinate of the beginning, as given to
            `avsec_gym.world.road.surface.road_meshes`.
        end: Road coordinate of the end, as given to the same.
        rng: The source of chance: where which plants grow.

    Returns:
        A mesh in the world frame at the height of the ground, reaching 900 m beyond the road.
    """
    roads = outline(site, start, end)
    xs, ys = _lines(roads.bounds)
    materials, kinds = _growth(site, roads.bounds, xs, ys, rng)
    first_x, first_y = np.meshgrid(xs[:-1], ys[:-1], indexing="ij")
    last_x, last_y = np.meshgrid(xs[1:], ys[1:], indexing="ij")
    boxes = np.asarray(shapely.box(first_x, first_y, last_x, last_y))
    shapely.prepare(roads)
    touched = np.asarray(shapely.intersects(roads, boxes))
    uneven = np.asarray(shapely.intersects(_uneven(site), boxes))

    open_land = _open_land(site, xs, ys, ~(touched | uneven), kinds, materials)
    coarse = touched & ~uneven
    fine, cells = _divided(boxes[uneven])
    pieces = np.concatenate([boxes[coarse], fine])
    shown = np.concatenate([kinds[coarse], kinds[uneven][cells]])
    free = ~shapely.contains(roads, pieces)
    pieces, shown = pieces[free], shown[free]
    cut = shapely.intersects(roads, pieces)
    pieces[cut] = shapely.difference(pieces[cut], roads)
    beside = [
        _cut_land(site, triangles(pieces[shown == kind]), material)
        for kind, material in enumerate(materials)
        if (shown == kind).any()
    ]
    return merge([open_land, *beside])


def _uneven(site: Site) -> shapely.Geometry:
    """Where the lattice is too coarse: level pads under actors, and small swells."""
    x, y, radius, height = site.ground.swells.T
    small = (radius < _SMALL_SWELL) & (np.abs(height) > 0.01)
    mounds = shapely.buffer(shapely.points(x[small], y[small]), 1.5 * radius[small])
    pads = site.ground.pads
    levels = rectangle_polygons(pads[:, :3], pads[:, 3], pads[:, 4])
    return shapely.union_all([*mounds, *shapely.buffer(levels, EASE)])


def _divided(boxes: np.ndarray) -> tuple[np.ndarray, NDArray[np.int64]]:
    """Pieces of boxes of a metre or less, and which box each belongs to."""
    pieces, cells = [], []
    for cell, (first_x, first_y, last_x, last_y) in enumerate(shapely.bounds(boxes)):
        count = int(np.ceil(max(last_x - first_x, last_y - first_y)))
        xs, ys = np.linspace(first_x, last_x, count + 1), np.linspace(first_y, last_y, count + 1)
        low_x, low_y = np.meshgrid(xs[:-1], ys[:-1])
        high_x, high_y = np.meshgrid(xs[1:], ys[1:])
        pieces.append(shapely.box(low_x, low_y, high_x, high_y).ravel())
        cells.append(np.full(count**2, cell))
    none = (np.zeros(0, object), np.zeros(0, np.int64))
    return (np.concatenate(pieces), np.concatenate(cells)) if pieces else none


def _open_land(
    site: Site,
    xs: Floats,
    ys: Floats,
    cells: NDArray[np.bool_],
    kinds: NDArray[np.int32],
    materials: tuple[Material, ...],
) -> Mesh:
    """Whole cells of the lattice."""
    x, y = np.meshgrid(xs, ys, indexing="ij")
    index = np.arange(x.size, dtype=np.int32).reshape(x.shape)
    a, b = index[:-1, :-1][cells], index[1:, :-1][cells]
    c, d = index[1:, 1:][cells], index[:-1, 1:][cells]
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return Mesh(
        np.stack([x, y, site.ground.height(x, y)], -1).reshape(-1, 3).astype(np.float32),
        ground_normals(site.ground, x, y).reshape(-1, 3),
        np.stack([x, -y], -1).reshape(-1, 2).astype(np.float32),
        faces,
        np.tile(kinds[cells], 2),
        materials,
    )


def _cut_land(site: Site, corners: Floats, material: Material) -> Mesh:
    x, y = corners.reshape(-1, 2).T
    return Mesh(
        np.stack([x, y, site.ground.height(x, y)], -1).astype(np.float32),
        ground_normals(site.ground, x, y),
        np.stack([x, -y], -1).astype(np.float32),
        np.arange(len(x), dtype=np.int32).reshape(-1, 3),
        np.zeros(len(corners), np.int32),
        (material,),
    )


def _lines(bounds: tuple[float, float, float, float]) -> tuple[Floats, Floats]:
    """The lattice's lines: even around the roads, ever wider beyond."""
    low = np.array(bounds[:2]) - _MARGIN
    high = np.array(bounds[2:]) + _MARGIN
    step = max(6.0, float(np.sqrt(np.prod(high - low) / _CELLS)))
    beyond = [step]
    while sum(beyond) < _REACH:
        beyond.append(beyond[-1] * _GROWTH)
    far = np.cumsum(beyond)
    lines = [
        np.concatenate(
            [
                first - far[::-1],
                np.linspace(first, last, int((last - first) / step) + 2),
                last + far,
            ]
        )
        for first, last in zip(low, high, strict=True)
    ]
    return lines[0], lines[1]


def _growth(
    site: Site,
    bounds: tuple[float, float, float, float],
    xs: Floats,
    ys: Floats,
    rng: np.random.Generator,
) -> tuple[tuple[Material, ...], NDArray[np.int32]]:
    """Materials, and which of them each cell shows: lots near the road, fields far off."""
    kinds = ground_materials(site)
    names = list(_NEAR[site.style])
    for outermost in (site.section.strips[0], site.section.strips[-1]):
        if outermost.surface == Surface.VERGE:
            # The verge goes on behind the road.
            names[0] = outermost.material
    near = [kinds[name] for name in names]
    fields = [Material(f"meadow/{i}", tint, infrared=0.5) for i, tint in enumerate(_GREENS)]
    if site.style in (Style.RURAL, Style.HIGHWAY):
        fields += [Material(f"field/{i}", infrared=0.35) for i in range(4)]
    x, y = 0.5 * (xs[1:] + xs[:-1]), 0.5 * (ys[1:] + ys[:-1])
    lots = _patchwork(x, y, 22.0, np.array([0, 0, 0, 0, 1, 2]), rng)
    parcels = _patchwork(x, y, 110.0, len(near) + np.arange(len(fields)), rng)
    away = np.maximum(
        np.maximum(bounds[0] - x, x - bounds[2])[:, None],
        np.maximum(bounds[1] - y, y - bounds[3])[None],
    )
    return (*near, *fields), np.where(away < 30.0, lots, parcels).astype(np.int32)


def _patchwork(
    x: Floats, y: Floats, size: float, choice: NDArray[np.int64], rng: np.random.Generator
) -> NDArray[np.int64]:
    """Rectangles of about `size` metres, each with one of the choices."""
    at_x = (x // (size * rng.uniform(0.8, 1.3))).astype(int)
    at_y = (y // (size * rng.uniform(0.5, 1.0))).astype(int)
    at_x, at_y = at_x - at_x.min(), at_y - at_y.min()
    drawn = rng.choice(choice, (at_x.max() + 1, at_y.max() + 1))
    return np.asarray(drawn[at_x][:, at_y])
