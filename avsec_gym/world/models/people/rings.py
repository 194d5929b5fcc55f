"""Bodies made of rings: cross-sections along limbs and tubes.

A ring is a polygon about an anchor.  To fill a given box, a body does not stretch: its anchors
move (a longer stride, elbows farther out, a longer wheelbase) while its cross-sections keep
their size.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh, merge

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Rings:
    """N rings of M points each; consecutive rings are joined by a band of faces.

    Args:
        anchors: Shape (N, 3), metres.
        offsets: Of the points from the anchor, shape (N, M, 3), clockwise seen by
            someone towards whom the rings advance.
        give: How far an anchor moves for each unit of the three loosenesses (along x, y, z),
            shape (N, 3).
        joined: Whether a ring continues the one before, shape (N,).
        codes: Material of the band between this ring and the one before, shape (N, M).
        materials: What the codes mean.
        uv: On the texture, metres, shape (N, M + 1, 2).
    """

    anchors: Floats
    offsets: Floats
    give: Floats
    joined: NDArray[np.bool_]
    codes: NDArray[np.int32]
    materials: tuple[Material, ...]
    uv: Floats

    def points(self, looseness: ArrayLike = (0.0, 0.0, 0.0)) -> Floats:
        """Where the points are, shape (N, M, 3)."""
        moved = self.anchors + self.give * np.asarray(looseness, float)
        return moved[:, None] + self.offsets

    def carried(self, rotation: ArrayLike, shift: ArrayLike) -> Rings:
        """Turned about the origin, then moved."""
        turn = np.asarray(rotation, float).T
        return replace(
            self,
            anchors=self.anchors @ turn + np.asarray(shift, float),
            offsets=self.offsets @ turn,
        )

    def attached(self, anchor: ArrayLike, give: ArrayLike = (0.0, 0.0, 0.0)) -> Rings:
        """The same shape as one rigid thing that moves with one anchor."""
        point = np.asarray(anchor, float)
        return replace(
            self,
            anchors=np.broadcast_to(point, self.anchors.shape),
            offsets=self.offsets + (self.anchors - point)[:, None],
            give=np.broadcast_to(np.asarray(give, float), self.anchors.shape),
        )


def sweep(
    anchors: ArrayLike,
    tangents: ArrayLike,
    front: ArrayLike,
    sizes: ArrayLike,
    materials: Material | Sequence[Material],
    *,
    sides: int = 8,
    codes: ArrayLike = 0,
    give: ArrayLike = (0.0, 0.0, 0.0),
    squareness: ArrayLike = 0.0,
    capped: bool = True,
) -> Rings:
    """Rings along a path, each an oval whose front and back may differ.

    Args:
        anchors: Shape (n, 3).
        tangents: The path's direction, shape (n, 3) or (3,).
        front: Roughly where the front of the ring is, shape (n, 3) or (3,).
        sizes: Half sizes to the front, to the back and to the sides, shape (n, 3) or (3,),
            metres.
        materials: One or several.
        sides: Points of a ring.
        codes: Which material, shape (n, sides), (n, 1) or a number.
        give: See `Rings`, shape (n, 3) or (3,).
        squareness: 0 for ovals, 0.5 for rounded rectangles; shape (n,) or a number.
        capped: Close the ends.
    """
    centres = np.asarray(anchors, float)
    count = len(centres)
    along = unit(np.broadcast_to(np.asarray(tangents, float), (count, 3)))
    ahead = np.broadcast_to(np.asarray(front, float), (count, 3))
    ahead = unit(ahead - np.sum(ahead * along, axis=1, keepdims=True) * along)
    aside = np.cross(ahead, along)
    angle = np.linspace(0.0, 2.0 * np.pi, sides, endpoint=False)
    cos, sin = np.cos(angle), np.sin(angle)
    square = np.broadcast_to(np.asarray(squareness, float), (count,))[:, None]
    corner = 1.0 / np.maximum(np.abs(cos), np.abs(sin))
    bulge = 1.0 + square * (corner - 1.0)
    half = np.broadcast_to(np.asarray(sizes, float), (count, 3))
    depth = np.where(cos >= 0, half[:, :1], half[:, 1:2]) * cos * bulge
    breadth = half[:, 2:] * sin * bulge
    offsets = depth[..., None] * ahead[:, None] + breadth[..., None] * aside[:, None]
    girth = np.pi * (0.5 * half[:, 0] + 0.5 * half[:, 1] + half[:, 2]).max()
    steps = np.linalg.norm(np.diff(centres, axis=0), axis=1)
    way = np.concatenate([[0.0], np.cumsum(steps)])
    uv = np.stack(np.broadcast_arrays(np.linspace(0, girth, sides + 1), way[:, None]), axis=-1)
    rings = Rings(
        centres,
        offsets,
        np.broadcast_to(np.asarray(give, float), (count, 3)),
        np.arange(count) > 0,
        np.broadcast_to(np.asarray(codes, np.int32), (count, sides)),
        (materials,) if isinstance(materials, Material) else tuple(materials),
        uv,
    )
    return _capped(rings) if capped else rings


def rods(
    starts: ArrayLike,
    ends: ArrayLike,
    radius: ArrayLike,
    material: Material,
    *,
    sides: int = 5,
    give: tuple[ArrayLike, ArrayLike] = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
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
    first, last = np.asarray(starts, float), np.asarray(ends, float)
    count = len(first)
    direction = last - first
    helper = np.where(np.abs(unit(direction)[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    pairs = np.stack([first, last], axis=1).reshape(-1, 3)
    gives = [np.broadcast_to(np.asarray(part, float), (count, 3)) for part in give]
    rings = sweep(
        pairs,
        np.repeat(direction, 2, axis=0),
        np.repeat(helper, 2, axis=0),
        np.repeat(np.broadcast_to(np.asarray(radius, float), (count,)), 2)[:, None].repeat(3, 1),
        material,
        sides=sides,
        give=np.stack(gives, axis=1).reshape(-1, 3),
        capped=False,
    )
    return replace(rings, joined=np.arange(2 * count) % 2 == 1)


def filling(
    parts: Sequence[Rings],
    dimensions: tuple[float, float, float],
    limits: ArrayLike = ((-0.7, 1.0), (-0.4, 0.5), (0.0, 0.0)),
) -> Mesh:
    """The parts as a mesh that fills a box: loosened as far as allowed, stretched for the rest.

    Args:
        parts: At least one.
        dimensions: Height, width, length, metres.
        limits: Least and greatest looseness along x, y and z.
    """
    height, width, length = dimensions
    targets = (length, width, height)
    points = np.concatenate([part.points().reshape(-1, 3) for part in parts])
    gives = np.concatenate([part.give.repeat(part.offsets.shape[1], axis=0) for part in parts])
    looseness = [
        _solved(points[:, axis], gives[:, axis], target, *bounds)
        for axis, (target, bounds) in enumerate(
            zip(targets, np.asarray(limits, float).tolist(), strict=True)
        )
    ]
    return surface(parts, looseness).fitted(length, width, height)


def surface(parts: Sequence[Rings], looseness: ArrayLike = (0.0, 0.0, 0.0)) -> Mesh:
    """The parts as one smooth mesh."""
    sizes = sorted({part.offsets.shape[1] for part in parts})
    return merge(
        [_skin([part for part in parts if part.offsets.shape[1] == m], looseness) for m in sizes]
    )


def unit(vectors: ArrayLike) -> Floats:
    """Vectors of length 1."""
    values = np.asarray(vectors, float)
    length = np.sqrt(np.sum(values * values, axis=-1, keepdims=True))
    return np.asarray(values / np.maximum(length, 1e-9))


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


def _capped(rings: Rings) -> Rings:
    """A point ring before the first and after the last one."""
    ends = np.r_[0, np.arange(len(rings.anchors)), -1]
    offsets = rings.offsets[ends]
    centres = offsets.mean(axis=1, keepdims=True)
    offsets[[0, -1]] = centres[[0, -1]]
    return replace(
        rings,
        anchors=rings.anchors[ends],
        offsets=offsets,
        give=rings.give[ends],
        joined=np.r_[rings.joined[:1], True, rings.joined[1:], True],
        codes=rings.codes[ends],
        uv=rings.uv[ends],
    )


def _skin(parts: Sequence[Rings], looseness: ArrayLike) -> Mesh:
    points = np.concatenate([part.points(looseness) for part in parts])
    joined = np.concatenate([part.joined for part in parts])
    count, sides = points.shape[:2]
    row = np.arange(count)
    before = np.where(joined, row - 1, row)
    after = np.where(np.r_[joined[1:], False], row + 1, row)
    across = np.roll(points, -1, axis=1) - np.roll(points, 1, axis=1)
    normals = unit(_cross(points[after] - points[before], across))
    pole = np.abs(across).max(axis=(1, 2)) < 1e-6
    centres = points.mean(axis=1)
    outward = unit(2.0 * centres - centres[after] - centres[before])
    normals[pole] = outward[pole, None]
    seam = np.r_[np.arange(sides), 0]
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


def _cross(first: Floats, second: Floats) -> Floats:
    """np.cross, several times as fast."""
    a, b, c = first[..., 0], first[..., 1], first[..., 2]
    x, y, z = second[..., 0], second[..., 1], second[..., 2]
    return np.stack([b * z - c * y, c * x - a * z, a * y - b * x], axis=-1)
