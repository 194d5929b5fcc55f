"""Things along a path: a cross-section drawn along it, or one piece again and again."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import ArrayLike

from avsec_gym.geometry import Floats
from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.shapes import polygon


def swept(path: ArrayLike, profile: ArrayLike, material: Material) -> Mesh:
    """A cross-section drawn along a path, with hard edges, closed at both ends: rail, wall, deck.

    Args:
        path: Points of the path, shape (n, 3), metres.
        profile: The cross-section's corners to the left of the path and up from it,
            counter-clockwise in these axes, shape (m, 2).
        material: Material of all faces: on walls u runs along the path and v down from the
            profile's top; on flat parts v runs across.
    """
    line, section = np.asarray(path, float), np.asarray(profile, float)
    left, run = _lefts(line), lengths(line)
    edge = np.stack([section, np.roll(section, -1, axis=0)], axis=1)
    step = edge[:, 1] - edge[:, 0]
    corners = line[:, None, None] + edge[None, ..., :1] * left[:, None, None]
    corners[..., 2] += edge[..., 1]
    across = left / np.linalg.norm(left, axis=1, keepdims=True)
    outward = step[:, 1:] * across[:, None] - step[:, :1] * [0.0, 0.0, 1.0]
    outward /= np.linalg.norm(outward, axis=2, keepdims=True)
    steep = np.abs(step[:, 1]) >= np.abs(step[:, 0])
    down = np.where(steep[:, None], section[:, 1].max() - edge[..., 1], edge[..., 0])
    shape = corners.shape[:3]
    uv = np.stack(np.broadcast_arrays(run[:, None, None], down), axis=-1)
    index = np.arange(np.prod(shape), dtype=np.int32).reshape(shape)
    a, b = index[:-1, :, 0], index[1:, :, 0]
    c, d = index[1:, :, 1], index[:-1, :, 1]
    faces = np.stack([np.stack([a, d, c], -1), np.stack([a, c, b], -1)], axis=-2).reshape(-1, 3)
    body = Mesh(
        corners.reshape(-1, 3).astype(np.float32),
        np.repeat(outward[:, :, None], 2, axis=2).reshape(-1, 3).astype(np.float32),
        uv.reshape(-1, 2).astype(np.float32),
        faces,
        np.zeros(len(faces), np.int32),
        (material,),
    )
    caps = []
    for at, order in ((0, -1), (-1, 1)):
        for triangle in _triangles(section)[:, ::order]:
            caps.append(
                polygon(
                    line[at] + triangle[:, :1] * left[at] + triangle[:, 1:] * [0, 0, 1], material
                )
            )
    return merge([body, *caps])


def copies(mesh: Mesh, places: ArrayLike) -> Mesh:
    """One piece at many places: posts, bars.

    Args:
        mesh: The piece.
        places: Poses as x, y, z, yaw, shape (n, 4).
    """
    rows = np.asarray(places, np.float32).reshape(-1, 4)
    count, size = len(rows), len(mesh.vertices)
    cos, sin = np.cos(rows[:, 3]), np.sin(rows[:, 3])
    nothing, one = np.zeros(count, np.float32), np.ones(count, np.float32)
    turn = np.array([[cos, sin, nothing], [-sin, cos, nothing], [nothing, nothing, one]])
    turn = turn.transpose(2, 0, 1)
    shift = np.repeat(np.arange(count, dtype=np.int32) * np.int32(size), len(mesh.faces))
    return Mesh(
        (mesh.vertices @ turn + rows[:, None, :3]).reshape(-1, 3),
        np.asarray(mesh.normals @ turn, np.float32).reshape(-1, 3),
        np.tile(mesh.uv, (count, 1)),
        np.tile(mesh.faces, (count, 1)) + shift[:, None],
        np.tile(mesh.material, count),
        mesh.materials,
    )


def along(path: ArrayLike, spacing: float) -> Floats:
    """Evenly spaced places on a path, both ends included.

    Args:
        path: Points of the path, shape (n, 3), metres.
        spacing: Approximate distance between places, metres.

    Returns:
        x, y, z and the path's heading, shape (k, 4).
    """
    line = np.asarray(path, float)
    run = lengths(line)
    at = np.linspace(0.0, run[-1], max(2, round(run[-1] / spacing) + 1))
    segment = np.clip(np.searchsorted(run, at, side="right") - 1, 0, len(line) - 2)
    step = np.diff(line, axis=0)[segment]
    return np.column_stack([_located(line, at), np.arctan2(step[:, 1], step[:, 0])])


def lengths(path: ArrayLike) -> Floats:
    """Metres along a path, shape (n, 3), from its start to each of its points, shape (n,)."""
    steps = np.linalg.norm(np.diff(np.asarray(path, float), axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


def _located(path: ArrayLike, run: ArrayLike) -> Floats:
    """Where one is after so many metres along a path, shape (k, 3)."""
    line = np.asarray(path, float)
    at, ends = np.asarray(run, float), lengths(line)
    return np.stack([np.interp(at, ends, line[:, axis]) for axis in range(3)], axis=-1)


def _lefts(line: Floats) -> Floats:
    """To the left at each point, longer in bends so that the profile keeps its width."""
    step = np.diff(line[:, :2], axis=0)
    step /= np.linalg.norm(step, axis=1, keepdims=True)
    middle = np.concatenate([step[:1], step[:-1] + step[1:], step[-1:]])
    middle[1:-1] *= 0.5
    # |middle| is the cosine of half the bend.
    middle /= np.maximum((middle**2).sum(axis=1, keepdims=True), 0.25)
    return np.column_stack([-middle[:, 1], middle[:, 0], np.zeros(len(line))])


def _triangles(section: Floats) -> Floats:
    """The cross-section cut into triangles, counter-clockwise, shape (k, 3, 2)."""
    parts = shapely.constrained_delaunay_triangles(shapely.Polygon(section)).geoms
    return np.array([shapely.orient_polygons(part).exterior.coords[:3] for part in parts])
