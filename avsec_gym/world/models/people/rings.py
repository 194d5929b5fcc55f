"""Bodies made of rings: cross-sections along limbs and tubes.

To fill a given box, a body does not stretch: its rings move apart (a longer stride, elbows farther
out, a longer wheelbase) while they keep their size.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh, merge

Floats = NDArray[np.float64]
Limits = tuple[tuple[float, float], tuple[float, float], tuple[float, float]]


@dataclass(frozen=True, eq=False)
class Rings:
    """N rings of M points each; consecutive rings are joined by a band of faces.

    Args:
        points: Shape (N, M, 3), metres, clockwise seen by someone towards whom the rings
            advance.
        give: How far a point moves for each unit of the three loosenesses (along x, y, z),
            shape (N, M, 3) or, for whole rings, (N, 1, 3).
        joined: Whether a ring continues the one before, shape (N,).
        codes: Material of the band between this ring and the one before, shape (N, M).
        materials: What the codes mean.
        uv: On the texture, metres, shape (N, M + 1, 2).
    """

    points: Floats
    give: Floats
    joined: NDArray[np.bool_]
    codes: NDArray[np.int32]
    materials: tuple[Material, ...]
    uv: Floats

    def carried(self, rotation: ArrayLike, shift: ArrayLike, give: ArrayLike = 0.0) -> Rings:
        """Turned about the origin, then moved: a rigid thing with one give."""
        points = self.points @ np.asarray(rotation, float).T + np.asarray(shift, float)
        gives = np.zeros_like(self.give)
        gives[...] = give
        return replace(self, points=points, give=gives)


def sweep(
    centres: Floats,
    tangents: ArrayLike,
    front: ArrayLike,
    sizes: ArrayLike,
    materials: Material | Sequence[Material],
    *,
    sides: int = 8,
    codes: ArrayLike = 0,
    give: ArrayLike = 0.0,
    squareness: float = 0.0,
    capped: bool = True,
) -> Rings:
    """Rings along a path, each an oval whose front and back may differ.

    Args:
        centres: Shape (n, 3).
        tangents: The path's direction, shape (n, 3) or (3,).
        front: Roughly where the front of the ring is, shape (n, 3) or (3,).
        sizes: Half sizes to the front, to the back and to the sides, shape (n, 3) or (3,),
            metres.
        materials: One or several.
        sides: Points of a ring.
        codes: Which material, shape (n, sides), (n, 1) or a number.
        give: See `Rings`, shape (n, 3) or (3,).
        squareness: 0 for ovals, 1 for rectangles.
        capped: Close the ends by a point ring each.
    """
    index = np.concatenate([[0], np.arange(len(centres)), [-1]]) if capped else slice(None)
    centres = centres[index]
    count = len(centres)
    along, ahead, half, give = (
        _rows(values, count, index) for values in (tangents, front, sizes, give)
    )
    along = unit(along)
    ahead = unit(ahead - np.einsum("ij,ij->i", ahead, along)[:, None] * along)
    aside = cross(ahead, along)
    if capped:
        half[[0, -1]] = 0.0
    cos, sin, corner = _circle(sides)
    bulge = 1.0 + squareness * corner
    depth = np.where(cos >= 0, half[:, :1], half[:, 1:2]) * (cos * bulge)
    breadth = half[:, 2:] * (sin * bulge)
    points = centres[:, None] + depth[..., None] * ahead[:, None] + breadth[..., None] * aside[:, None]
    uv = np.empty((count, sides + 1, 2))
    uv[..., 0] = np.linspace(0.0, np.pi * (half @ [0.5, 0.5, 1.0]).max(), sides + 1)
    step = centres[1:] - centres[:-1]
    uv[0, :, 1] = 0.0
    uv[1:, :, 1] = np.cumsum(np.sqrt(np.einsum("ij,ij->i", step, step)))[:, None]
    band = np.empty((count, sides), np.int32)
    band[...] = codes if np.ndim(codes) == 0 else np.asarray(codes)[index]
    return Rings(
        points,
        give[:, None],
        np.arange(count) > 0,
        band,
        (materials,) if isinstance(materials, Material) else tuple(materials),
        uv,
    )


def rods(
    starts: Floats,
    ends: Floats,
    radius: ArrayLike,
    material: Material,
    *,
    sides: int = 5,
    give: tuple[ArrayLike, ArrayLike] = (0.0, 0.0),
) -> Rings:
    """Straight round bars: frame tubes, spokes, straps.

    Args:
        starts: Shape (k, 3).
        ends: Shape (k, 3).
        radius: Shape (k,) or one for all, metres.
        material: Of all.
        sides: Of the cross-section's polygon.
        give: Of starts and of ends, each of shape (k, 3) or (3,).
    """
    count = len(starts)
    direction = unit(ends - starts)
    helper = np.where(np.abs(direction[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    thickness = np.empty(count)
    thickness[...] = radius
    gives = [_rows(part, count, slice(None)) for part in give]
    rings = sweep(
        np.stack([starts, ends], axis=1).reshape(-1, 3),
        direction.repeat(2, axis=0),
        helper.repeat(2, axis=0),
        thickness.repeat(2)[:, None].repeat(3, axis=1),
        material,
        sides=sides,
        give=np.stack(gives, axis=1).reshape(-1, 3),
        capped=False,
    )
    return replace(rings, joined=np.arange(2 * count) % 2 == 1)


def filling(
    parts: Sequence[Rings],
    dimensions: tuple[float, float, float],
    limits: Limits = ((-0.7, 0.7), (-0.12, 0.3), (0.0, 0.0)),
) -> Mesh:
    """The parts as a mesh that fills a box: loosened as far as allowed, stretched for the rest.

    Args:
        parts: At least one.
        dimensions: Height, width, length, metres.
        limits: Least and greatest looseness along x, y and z.
    """
    height, width, length = dimensions
    points = np.concatenate([part.points.reshape(-1, 3) for part in parts])
    gives = np.concatenate([np.broadcast_to(p.give, p.points.shape).reshape(-1, 3) for p in parts])
    looseness = [
        _solved(points[:, axis], gives[:, axis], target, low, high)
        for axis, target, (low, high) in zip(range(3), (length, width, height), limits, strict=True)
    ]
    return surface(parts, looseness).fitted(length, width, height)


def surface(parts: Sequence[Rings], looseness: ArrayLike = (0.0, 0.0, 0.0)) -> Mesh:
    """The parts as one smooth mesh."""
    sizes = sorted({part.points.shape[1] for part in parts})
    return merge(
        [_skin([part for part in parts if part.points.shape[1] == m], looseness) for m in sizes]
    )


def unit(vectors: ArrayLike) -> Floats:
    """Vectors of length 1."""
    values = np.asarray(vectors, float)
    length = np.sqrt(np.einsum("...i,...i->...", values, values))[..., None]
    return np.asarray(values / np.maximum(length, 1e-9))


def cross(first: Floats, second: Floats) -> Floats:
    """np.cross, several times as fast."""
    a, b, c = first[..., 0], first[..., 1], first[..., 2]
    x, y, z = second[..., 0], second[..., 1], second[..., 2]
    return np.stack([b * z - c * y, c * x - a * z, a * y - b * x], axis=-1)


def _solved(points: Floats, give: Floats, target: float, low: float, high: float) -> float:
    """The looseness at which an extent, convex in it, reaches its target."""
    free = np.abs(give) > 1e-9
    if not free.any() or low >= high:
        return 0.0
    rigid = points[~free]
    top, bottom = (rigid.max(), rigid.min()) if len(rigid) else (-np.inf, np.inf)
    points, give = points[free], give[free]
    for _ in range(12):
        middle = 0.5 * (low + high)
        moved = points + middle * give
        if max(moved.max(), top) - min(moved.min(), bottom) < target:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def _rows(values: ArrayLike, count: int, index: NDArray[np.int64] | slice) -> Floats:
    """A row for each ring, shape (count, 3), from rows, one row or a number."""
    given = np.asarray(values, float)
    rows = np.empty((count, 3))
    rows[...] = given[index] if given.ndim == 2 else given
    return rows


@functools.cache
def _circle(sides: int) -> tuple[Floats, Floats, Floats]:
    """Cosines, sines, and how much farther out a square is than its circle."""
    angle = np.linspace(0.0, 2.0 * np.pi, sides, endpoint=False)
    cos, sin = np.cos(angle), np.sin(angle)
    return cos, sin, 1.0 / np.maximum(np.abs(cos), np.abs(sin)) - 1.0


def _skin(parts: Sequence[Rings], looseness: ArrayLike) -> Mesh:
    loose = np.asarray(looseness, float)
    points = np.concatenate([part.points + part.give * loose for part in parts])
    joined = np.concatenate([part.joined for part in parts])
    count, sides = points.shape[:2]
    row = np.arange(count)
    before = np.where(joined, row - 1, row)
    after = np.append(before[1:] != row[1:], False) + row
    across = points[:, np.arange(1, sides + 1) % sides] - points[:, np.arange(sides) - 1]
    normals = unit(cross(points[after] - points[before], across))
    pole = np.abs(across).max(axis=(1, 2)) < 1e-6
    centres = points.mean(axis=1)
    outward = unit(2.0 * centres - centres[after] - centres[before])
    normals[pole] = outward[pole, None]
    seam = np.append(np.arange(sides), 0)
    lower, upper = before[joined], row[joined]
    corner = np.arange(count * (sides + 1)).reshape(count, sides + 1)
    a, b = corner[lower, :-1], corner[upper, :-1]
    c, d = corner[upper, 1:], corner[lower, 1:]
    codes, materials = _materials(parts)
    band = codes[upper]
    wide, started = ~pole[upper], ~pole[lower]
    faces = [np.stack([a, b, c], -1)[wide], np.stack([a, c, d], -1)[started]]
    return Mesh(
        points[:, seam].reshape(-1, 3).astype(np.float32),
        normals[:, seam].reshape(-1, 3).astype(np.float32),
        np.concatenate([part.uv for part in parts]).reshape(-1, 2).astype(np.float32),
        np.concatenate([face.reshape(-1, 3) for face in faces]).astype(np.int32),
        np.concatenate([band[wide].ravel(), band[started].ravel()]),
        materials,
    )


def _materials(parts: Sequence[Rings]) -> tuple[NDArray[np.int32], tuple[Material, ...]]:
    index: dict[Material, int] = {}
    codes = [
        np.array([index.setdefault(material, len(index)) for material in part.materials], np.int32)[
            part.codes
        ]
        for part in parts
    ]
    return np.concatenate(codes), tuple(index)
