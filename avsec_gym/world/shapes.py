"""Simple shapes from which the models are built."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import ArrayLike

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Float32s, Mesh, merge

_PLAIN = Material()


def grid(
    points: ArrayLike,
    uv: ArrayLike | None = None,
    material: Material = _PLAIN,
    *,
    closed: bool = False,
    overlay_uv: ArrayLike | None = None,
) -> Mesh:
    """A smooth surface through a grid of points: road, hill, car body (a loft of sections).

    Args:
        points: Points of the grid, shape (n, m, 3).  The outside is where rows cross columns: with
            rows counted along x and columns along y, it is up.
        uv: Places on the texture, metres, shape (n, m, 2); arc lengths along columns and rows if
            None.
        material: Material of all faces.
        closed: The last column is the first one again, and shading is to run on across the seam.
        overlay_uv: Places on the overlay, metres, shape (n, m, 2).
    """
    corners = np.asarray(points, np.float64)
    rows, columns = corners.shape[:2]
    along, across = np.gradient(corners, axis=0), np.gradient(corners, axis=1)
    if closed:
        seam = corners[:, 1] - corners[:, -2]
        across[:, 0] = across[:, -1] = seam
    normals = _unit(np.cross(along, across))
    if uv is None:
        uv = np.stack([_arc_lengths(corners, 0), _arc_lengths(corners, 1)], axis=-1)
    index = np.arange(rows * columns, dtype=np.int32).reshape(rows, columns)
    a, b = index[:-1, :-1].ravel(), index[1:, :-1].ravel()
    c, d = index[1:, 1:].ravel(), index[:-1, 1:].ravel()
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return Mesh(
        corners.reshape(-1, 3).astype(np.float32),
        normals.reshape(-1, 3),
        np.asarray(uv, np.float32).reshape(-1, 2),
        faces,
        np.zeros(len(faces), np.int32),
        (material,),
        None if overlay_uv is None else np.asarray(overlay_uv, np.float32).reshape(-1, 2),
    )


def polygon(corners: ArrayLike, material: Material = _PLAIN, uv: ArrayLike | None = None) -> Mesh:
    """A flat convex polygon.

    Args:
        corners: Corners, shape (n, 3), counter-clockwise seen from outside.
        material: Material of the polygon.
        uv: Places on the texture, metres, shape (n, 2); if None, the first edge runs to the right
            along the texture's bottom edge (v = 0 there, and negative above, which repeats).
    """
    points = np.asarray(corners, np.float64)
    right = points[1] - points[0]
    # The sum over the fan: a corner within an edge does no harm.
    normal = np.cross(points[1:-1] - points[0], points[2:] - points[0]).sum(axis=0)
    if uv is None:
        right = right / np.linalg.norm(right)
        up = np.cross(normal, right)
        up /= np.linalg.norm(up)
        uv = np.stack([(points - points[0]) @ right, -(points - points[0]) @ up], axis=-1)
    count = len(points)
    fan = np.arange(1, count - 1, dtype=np.int32)
    faces = np.stack([np.zeros_like(fan), fan, fan + np.int32(1)], axis=1)
    return Mesh(
        points.astype(np.float32),
        np.tile(_unit(normal), (count, 1)),
        np.asarray(uv, np.float32),
        faces,
        np.zeros(len(faces), np.int32),
        (material,),
    )


def box(
    length: float,
    width: float,
    height: float,
    material: Material = _PLAIN,
    *,
    top: Material | None = None,
) -> Mesh:
    """A box with hard edges on the origin: length along x, width along y, its bottom at z = 0."""
    footprint = np.array([(1, -1), (1, 1), (-1, 1), (-1, -1)]) * [0.5 * length, 0.5 * width]
    return prism(footprint, height, material, top=top or material)


def prism(
    footprint: ArrayLike,
    height: float,
    material: Material = _PLAIN,
    *,
    top: Material | None = None,
    bottom: float = 0.0,
) -> Mesh:
    """Vertical walls over a simple polygon, with a flat roof (and floor) if `top` is given.

    Args:
        footprint: Corners counter-clockwise seen from above, shape (n, 2).
        height: Height of the walls' upper edge above z = 0, metres.
        material: Material of the walls; u runs round the building, v is 0 at the upper edge and
            grows downwards.
        top: Material of roof and floor.
        bottom: Height of the walls' lower edge.
    """
    plan = np.asarray(footprint, np.float64)
    parts = []
    start = 0.0
    for first, second in zip(plan, np.roll(plan, -1, axis=0), strict=True):
        length = float(np.linalg.norm(second - first))
        corners = [(*first, bottom), (*second, bottom), (*second, height), (*first, height)]
        low = height - bottom
        uv = [(start, low), (start + length, low), (start + length, 0), (start, 0)]
        parts.append(polygon(corners, material, uv))
        start += length
    if top is not None:
        for flat in _convex_parts(plan):
            parts.append(polygon(np.c_[flat, np.full(len(flat), height)], top, flat))
            below = np.c_[flat[::-1], np.full(len(flat), bottom)]
            parts.append(polygon(below, top, flat[::-1]))
    return merge(parts)


def tube(
    path: ArrayLike,
    radii: ArrayLike | float,
    material: Material = _PLAIN,
    *,
    sides: int = 10,
    capped: bool = True,
) -> Mesh:
    """A round tube along a path: pole, limb, trunk, tyre.

    Args:
        path: Points of the middle line, shape (n, 3), n >= 2, metres.
        radii: Radius at each point of the path, shape (n,), or one for all, metres.
        material: Material of the tube; u runs round it, v along it.
        sides: Number of sides of the cross-section's polygon.
        capped: Whether the ends are closed.
    """
    centres = np.asarray(path, np.float64)
    sizes = np.broadcast_to(np.asarray(radii, float), (len(centres),)).copy()
    tangents = _unit(np.gradient(centres, axis=0)).astype(float)
    if capped:
        centres = np.concatenate([centres[:1], centres, centres[-1:]])
        tangents = np.concatenate([tangents[:1], tangents, tangents[-1:]])
        sizes = np.concatenate([[1e-4], sizes, [1e-4]])
    first = _beside(tangents)
    second = np.cross(first, tangents)
    angle = np.linspace(0.0, 2.0 * np.pi, sides + 1)
    around = np.cos(angle)[:, None] * first[:, None] + np.sin(angle)[:, None] * second[:, None]
    points = centres[:, None] + sizes[:, None, None] * around
    uv = np.stack(
        [
            np.broadcast_to(angle * sizes.max(), points.shape[:2]),
            np.broadcast_to(_arc_lengths(points, 0)[:, :1], points.shape[:2]),
        ],
        axis=-1,
    )
    mesh = grid(points, uv, material, closed=True)
    if capped:
        mesh.normals[: sides + 1] = -tangents[0]
        mesh.normals[-(sides + 1) :] = tangents[-1]
    return mesh


def ellipsoid(
    centre: ArrayLike, radii: ArrayLike, material: Material = _PLAIN, *, rings: int = 10
) -> Mesh:
    """An ellipsoid with its poles above and below.

    Args:
        centre: Centre, shape (3,), metres.
        radii: Radii along x, y, z, shape (3,), metres.
        material: Material of the surface.
        rings: Number of rings of points between the poles; twice as many points go round.
    """
    polar = np.linspace(1e-3, np.pi - 1e-3, rings)[:, None]
    azimuth = np.linspace(0.0, 2.0 * np.pi, 2 * rings + 1)[None, :]
    direction = np.stack(
        np.broadcast_arrays(
            np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)
        ),
        axis=-1,
    )
    size = np.asarray(radii, float)
    mesh = grid(np.asarray(centre, float) + direction * size, None, material, closed=True)
    normals = _unit((direction / size).reshape(-1, 3))
    return Mesh(mesh.vertices, normals, mesh.uv, mesh.faces, mesh.material, mesh.materials)


def revolve(profile: ArrayLike, material: Material = _PLAIN, *, sides: int = 24) -> Mesh:
    """A profile turned about the z axis: lamp globe, bollard, wheel rim.

    Args:
        profile: Radius and height from the top down, shape (n, 2); the outside is away from
            the axis.
        material: Material of the surface.
        sides: Number of sides of the cross-section's polygon.
    """
    line = np.array(profile, float)
    line[:, 0] = np.maximum(line[:, 0], 1e-4)  # a normal needs some way round, also at the poles
    angle = np.linspace(0.0, 2.0 * np.pi, sides + 1)
    points = np.stack(
        [
            line[:, :1] * np.cos(angle),
            line[:, :1] * np.sin(angle),
            np.broadcast_to(line[:, 1:], (len(line), len(angle))),
        ],
        axis=-1,
    )
    return grid(points, None, material, closed=True)


def hard_edges(mesh: Mesh, angle: float = 0.6) -> Mesh:
    """Shading normals anew: smooth where neighbouring faces meet at less than `angle`.

    Args:
        mesh: Vertices at one place count as one, whatever their number.
        angle: Angle between two faces, radians.
    """
    corners = mesh.vertices[mesh.faces].astype(np.float64)
    facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    unit = _unit(facing).astype(np.float64)
    keys = np.round(mesh.vertices[mesh.faces].reshape(-1, 3) * 1e4).astype(np.int64)
    _, place = np.unique(keys, axis=0, return_inverse=True)
    place = place.reshape(-1)
    face = np.repeat(np.arange(len(corners)), 3)
    order = np.argsort(place, kind="stable")
    bounds = np.flatnonzero(np.diff(place[order])) + 1
    normals = np.zeros((len(face), 3))
    limit = np.cos(angle)
    for corner in np.split(order, bounds):
        owners = face[corner]
        close = unit[owners] @ unit[owners].T >= limit
        normals[corner] = close @ facing[owners]
    index = mesh.faces.reshape(-1)
    overlay = None if mesh.overlay_uv is None else mesh.overlay_uv[index]
    return Mesh(
        mesh.vertices[index],
        _unit(normals),
        mesh.uv[index],
        np.arange(len(index), dtype=np.int32).reshape(-1, 3),
        mesh.material,
        mesh.materials,
        overlay,
    )


def scattered(meshes: Sequence[Mesh], places: ArrayLike) -> Mesh:
    """Copies at many places: bars of a fence, slats, wheels.

    Args:
        meshes: Mesh of each place, or one for all.
        places: Poses as x, y, z, yaw, shape (n, 4).
    """
    rows = np.asarray(places, float).tolist()
    every = list(meshes) * (len(rows) if len(meshes) == 1 else 1)
    return merge([mesh.placed(*row) for mesh, row in zip(every, rows, strict=True)])


def _beside(tangents: np.ndarray) -> np.ndarray:
    """A direction square to each tangent, carried along so that it turns as little as it can."""
    helper = np.array([0.0, 0.0, 1.0] if abs(tangents[0, 2]) < 0.9 else [1.0, 0.0, 0.0])
    side = np.cross(tangents[0], helper)
    sides = []
    for tangent in tangents:
        side = side - (side @ tangent) * tangent
        side = side / np.linalg.norm(side)
        sides.append(side)
    return np.array(sides)


def _convex_parts(plan: np.ndarray) -> list[np.ndarray]:
    """The polygon itself if it is convex, else triangles."""
    edges = np.roll(plan, -1, axis=0) - plan
    onward = np.roll(edges, -1, axis=0)
    if (edges[:, 0] * onward[:, 1] - edges[:, 1] * onward[:, 0] >= 0).all():
        return [plan]
    triangles = shapely.constrained_delaunay_triangles(shapely.Polygon(plan)).geoms
    return [shapely.get_coordinates(shapely.orient_polygons(part))[:3] for part in triangles]


def _arc_lengths(points: np.ndarray, axis: int) -> np.ndarray:
    steps = np.linalg.norm(np.diff(points, axis=axis), axis=-1)
    start = np.zeros_like(np.take(steps, [0], axis=axis))
    return np.concatenate([start, np.cumsum(steps, axis=axis)], axis=axis)


def _unit(vectors: np.ndarray) -> Float32s:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.maximum(length, 1e-12), np.float32)
