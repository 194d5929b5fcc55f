"""Surfaces given in road coordinates, laid on the ground along a course."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import ArrayLike
from shapely.geometry.base import BaseGeometry

from avsec_gym.geometry import Floats
from avsec_gym.world.course import Course
from avsec_gym.world.ground import Ground
from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Float32s, Mesh
from avsec_gym.world.shapes import grid

_ACROSS, _ACROSS_PADS = 3.0, 1.0
"""Metres between vertices across a strip; less where the ground is levelled for an actor."""
_SLIVER = 1e-5
"""Square metres; smaller triangles are left out."""


class Lay(NamedTuple):
    """The course and ground on which things are laid, and where the overlay begins."""

    course: Course
    ground: Ground
    overlay_corner: tuple[float, float] | None = None
    """Road coordinates of the overlay's upper left corner; None: it is not painted on."""


def strip_meshes(
    lay: Lay,
    stations: Floats,
    edges: tuple[float, float],
    height: float,
    material: Material,
    hole: BaseGeometry | None = None,
) -> list[Mesh]:
    """A strip along the road, with a piece cut out.

    Args:
        lay: Course and ground on which the strip lies, and the overlay's corner.
        stations: Road coordinates of its rows, ascending, metres, shape (n,).
        edges: Right and left edge, metres to the left of the course.
        height: Height above the ground, metres.
        material: The material; v counts from the left edge, its u along the road.
        hole: Area in road coordinates that is left out.
    """
    step = _ACROSS if len(lay.ground.pads) == 0 else _ACROSS_PADS
    lefts = np.linspace(*edges, max(2, int(np.ceil((edges[1] - edges[0]) / step)) + 1))
    box = shapely.box(stations[0], edges[0], stations[-1], edges[1])
    cut = shapely.get_parts(shapely.intersection(hole, box)) if hole is not None else []
    cut = [part for part in cut if part.area > _SLIVER]
    meshes, done = [], 0
    for first, _, last, _ in sorted(part.bounds for part in cut):
        before = max(int(np.searchsorted(stations, first, side="right")) - 1, done)
        after = min(int(np.searchsorted(stations, last)), len(stations) - 1)
        if before > done:
            meshes.append(_rows(lay, stations[done : before + 1], lefts, height, material))
        if after > before:
            cells = shapely.difference(_cells(stations[before : after + 1], lefts), hole)
            meshes += _pieces(lay, cells, height, material, edges[1])
            done = after
    if done < len(stations) - 1:
        meshes.append(_rows(lay, stations[done:], lefts, height, material))
    return meshes


def area_meshes(lay: Lay, area: BaseGeometry, height: float, material: Material) -> list[Mesh]:
    """Any area in road coordinates."""
    if area.is_empty:
        return []
    first, right, last, left = area.bounds
    stations = np.arange(np.floor(first), np.ceil(last) + 1.0)
    lefts = np.linspace(right, left, max(2, int(np.ceil((left - right) / 2.0)) + 1))
    return _pieces(lay, shapely.intersection(_cells(stations, lefts), area), height, material, 0.0)


def wall_meshes(
    lay: Lay, lines: BaseGeometry, low: float, high: float, material: Material
) -> list[Mesh]:
    """Upright faces above lines in road coordinates; seen from the lines' right side.

    Args:
        lay: Course and ground on which the wall stands, and the overlay's corner.
        lines: LineStrings.
        low: Height of the lower edge above the ground, metres.
        high: Height of the upper edge above the ground, metres.
        material: Material of the faces.
    """
    parts = shapely.get_parts(shapely.line_merge(lines))
    return [_wall(lay, shapely.get_coordinates(part), low, high, material) for part in parts]


def laid(lay: Lay, along: ArrayLike, left: ArrayLike, height: ArrayLike) -> Floats:
    """Points in the world frame, shape (..., 3), from road coordinates of shape (...)."""
    poses = lay.course.poses(along, left)
    x, y = poses[..., 0], poses[..., 1]
    return np.stack([x, y, lay.ground.height(x, y) + np.asarray(height)], axis=-1)


def ground_normals(ground: Ground, x: Floats, y: Floats) -> Float32s:
    """Upward unit normals of the ground, shape (..., 3)."""
    step = 0.5
    slope_x = (ground.height(x + step, y) - ground.height(x - step, y)) / (2 * step)
    slope_y = (ground.height(x, y + step) - ground.height(x, y - step)) / (2 * step)
    normals = np.stack([-slope_x, -slope_y, np.ones_like(slope_x)], axis=-1)
    return np.asarray(normals / np.linalg.norm(normals, axis=-1, keepdims=True), np.float32)


def triangles(areas: Sequence[BaseGeometry] | np.ndarray) -> Floats:
    """All triangles of areas, counter-clockwise, shape (n, 3, 2)."""
    every = shapely.get_parts(shapely.constrained_delaunay_triangles(np.asarray(areas, object)))
    corners = shapely.get_coordinates(every).reshape(-1, 4, 2)[:, :3]
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    double_area = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    corners = np.where((double_area < 0)[:, None, None], corners[:, ::-1], corners)
    return np.asarray(corners[np.abs(double_area) > 2 * _SLIVER])


def _rows(lay: Lay, stations: Floats, lefts: Floats, height: float, material: Material) -> Mesh:
    along, left = np.meshgrid(stations, lefts, indexing="ij")
    uv = np.stack([along, lefts[-1] - left], axis=-1)
    return grid(
        laid(lay, along, left, height), uv, material, overlay_uv=_overlay_uv(lay, along, left)
    )


def _pieces(
    lay: Lay, cells: np.ndarray, height: float, material: Material, top: float
) -> list[Mesh]:
    corners = triangles(cells).reshape(-1, 2)
    if len(corners) == 0:
        return []
    along, left = corners[:, 0], corners[:, 1]
    points = laid(lay, along, left, height)
    faces = np.arange(len(corners), dtype=np.int32).reshape(-1, 3)
    mesh = Mesh(
        points.astype(np.float32),
        ground_normals(lay.ground, points[:, 0], points[:, 1]),
        np.stack([along, top - left], axis=-1).astype(np.float32),
        faces,
        np.zeros(len(faces), np.int32),
        (material,),
        _overlay_uv(lay, along, left),
    )
    return [mesh]


def _wall(lay: Lay, line: Floats, low: float, high: float, material: Material) -> Mesh:
    """A flat face for each piece of the line."""
    run = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    heights = np.array([low, low, high, high])
    which = np.arange(len(line) - 1)[:, None] + np.array([0, 1, 1, 0])
    points = laid(lay, line[which, 0], line[which, 1], heights)
    ahead = points[:, 1] - points[:, 0]
    normals = np.stack([ahead[:, 1], -ahead[:, 0], np.zeros(len(ahead))], axis=-1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True) + 1e-12
    uv = np.stack([run[which], np.broadcast_to(high - heights, which.shape)], axis=-1)
    first = 4 * np.arange(len(ahead), dtype=np.int32)[:, None]
    faces = (first + np.array([[0, 1, 2, 0, 2, 3]], np.int32)).reshape(-1, 3)
    return Mesh(
        points.reshape(-1, 3).astype(np.float32),
        np.repeat(normals, 4, axis=0).astype(np.float32),
        uv.reshape(-1, 2).astype(np.float32),
        faces,
        np.zeros(len(faces), np.int32),
        (material,),
    )


def _overlay_uv(lay: Lay, along: Floats, left: Floats) -> Float32s | None:
    if lay.overlay_corner is None:
        return None
    start, top = lay.overlay_corner
    return np.stack([along - start, top - left], axis=-1).astype(np.float32)


def _cells(stations: Floats, lefts: Floats) -> np.ndarray:
    first, right = np.meshgrid(stations[:-1], lefts[:-1], indexing="ij")
    last, left = np.meshgrid(stations[1:], lefts[1:], indexing="ij")
    return np.asarray(shapely.box(first, right, last, left)).ravel()
