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
        centres: Shape (N, 3), metres.
        along: Where the rings advance, shape (N, 3), of any length.
        front: Roughly where a ring's front is, shape (N, 3).
        sizes: Half sizes to the front, to the back and to the sides, shape (N, 3), metres.
        give: How far a ring moves for each unit of the three loosenesses (along x, y, z), shape
            (N, 3).
        joined: Whether a ring continues the one before, shape (N,).
        codes: Material of the band between this ring and the one before, shape (N, M).
        materials: What the codes mean.
        squareness: 0 for ovals, 1 for rectangles, shape (N,).
        swell: Growth of front and back for each unit of looseness along x, shape (N,).
        bulge: How much farther out the points are than the oval, as a factor, shape (N, M).
        uv: On the texture, metres, shape (N, M + 1, 2); None for lengths round and along.
    """

    centres: Floats
    along: Floats
    front: Floats
    sizes: Floats
    give: Floats
    joined: NDArray[np.bool_]
    codes: NDArray[np.int32]
    materials: tuple[Material, ...]
    squareness: Floats
    swell: Floats
    bulge: Floats | None = None
    uv: Floats | None = None

    def carried(self, rotation: Floats, shift: Floats, give: ArrayLike = 0.0) -> Rings:
        """Turned about the origin, then moved: a rigid thing with one give."""
        turn = rotation.T
        gives = np.empty_like(self.give)
        gives[...] = give
        return replace(
            self,
            centres=self.centres @ turn + shift,
            along=self.along @ turn,
            front=self.front @ turn,
            give=gives,
        )


def sweep(
    centres: Floats,
    along: ArrayLike,
    front: ArrayLike,
    sizes: ArrayLike,
    materials: Material | Sequence[Material],
    *,
    sides: int = 8,
    codes: ArrayLike = 0,
    give: ArrayLike = 0.0,
    squareness: float = 0.0,
    swell: ArrayLike = 0.0,
    capped: bool = True,
) -> Rings:
    """Rings along a path, each an oval whose front and back may differ.

    Args:
        centres: Shape (n, 3).
        along: The path's direction, shape (n, 3) or (3,).
        front: Roughly where the front of the ring is, shape (n, 3) or (3,).
        sizes: Half sizes to the front, to the back and to the sides, shape (n, 3) or (3,),
            metres.
        materials: One or several.
        sides: Points of a ring.
        codes: Which material, shape (n, sides), (n, 1) or a number.
        give: See `Rings`, shape (n, 3) or (3,).
        squareness: See `Rings`.
        swell: See `Rings`, shape (n,) or a number.
        capped: Close the ends by a point ring each.
    """
    count = len(centres)
    index = _ends_twice(count) if capped else slice(None)
    half = _rows(sizes, (count, 3))[index]
    if capped:
        half[[0, -1]] = 0.0
    directions = _rows(along, (count, 3)), _rows(front, (count, 3)), _rows(give, (count, 3))
    total = len(half)
    return Rings(
        centres[index],
        directions[0][index],
        directions[1][index],
        half,
        directions[2][index],
        np.arange(total) > 0,
        _rows(codes, (count, sides))[index].astype(np.int32),
        (materials,) if isinstance(materials, Material) else tuple(materials),
        np.full(total, squareness),
        _rows(swell, (count,))[index],
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
    direction = ends - starts
    steep = np.abs(direction[:, 2:]) > 2.0 * np.abs(direction[:, :2]).max(axis=1, keepdims=True)
    front = np.where(steep, [[1.0, 0.0, 0.0]], [[0.0, 0.0, 1.0]])
    first, last = (_rows(part, (count, 3)) for part in give)
    rings = sweep(
        np.stack([starts, ends], axis=1).reshape(-1, 3),
        direction.repeat(2, axis=0),
        front.repeat(2, axis=0),
        _rows(radius, (count,)).repeat(2)[:, None].repeat(3, axis=1),
        material,
        sides=sides,
        give=np.stack([first, last], axis=1).reshape(-1, 3),
        capped=False,
    )
    return replace(rings, joined=np.arange(2 * count) % 2 == 1)


def filling(
    parts: Sequence[Rings],
    dimensions: tuple[float, float, float],
    limits: Limits = ((-0.7, 1.1), (-0.12, 0.3), (0.0, 0.0)),
) -> Mesh:
    """The parts as a mesh that fills a box: loosened as far as allowed, stretched for the rest.

    Args:
        parts: At least one.
        dimensions: Height, width, length, metres.
        limits: Least and greatest looseness along x, y and z.
    """
    height, width, length = dimensions
    groups = _groups(parts)
    places = [_points(group) for group in groups]
    points, gives = (
        np.concatenate([pair[number].reshape(-1, 3) for pair in places]).T.copy()
        for number in range(2)
    )
    looseness = np.array(
        [
            _solved(points[axis], gives[axis], target, *limits[axis])
            for axis, target in enumerate((length, width, height))
        ]
    )
    skins = [
        _skin(group, point + give * looseness)
        for group, (point, give) in zip(groups, places, strict=True)
    ]
    return merge(skins).fitted(length, width, height)


def surface(parts: Sequence[Rings]) -> Mesh:
    """The parts as one smooth mesh, where they are."""
    return merge([_skin(group, _points(group)[0]) for group in _groups(parts)])


def unit(vectors: ArrayLike) -> Floats:
    """Vectors of length 1."""
    values = np.asarray(vectors, float)
    length = np.sqrt(np.einsum("...i,...i->...", values, values))[..., None]
    return np.asarray(values / np.maximum(length, 1e-9))


def _ends_twice(count: int) -> NDArray[np.int64]:
    return np.arange(-1, count + 1).clip(0, count - 1)


def _rows(values: ArrayLike, shape: tuple[int, ...]) -> Floats:
    """np.broadcast_to, quicker."""
    rows = np.empty(shape)
    rows[...] = values
    return rows


@functools.cache
def _circle(sides: int) -> tuple[Floats, Floats, Floats]:
    """Cosines, sines, and how much farther out a square is than its circle."""
    angle = np.linspace(0.0, 2.0 * np.pi, sides, endpoint=False)
    cos, sin = np.cos(angle), np.sin(angle)
    return cos, sin, 1.0 / np.maximum(np.abs(cos), np.abs(sin)) - 1.0


def _groups(parts: Sequence[Rings]) -> list[Rings]:
    """All parts with equally many points in a ring as one."""
    sizes = sorted({part.codes.shape[1] for part in parts})
    return [_joined([part for part in parts if part.codes.shape[1] == size]) for size in sizes]


def _joined(parts: Sequence[Rings]) -> Rings:
    index: dict[Material, int] = {}
    codes = []
    for part in parts:
        numbers = [index.setdefault(material, len(index)) for material in part.materials]
        codes.append(np.array(numbers, np.int32)[part.codes])
    bulges = [
        np.ones(part.codes.shape) if part.bulge is None else part.bulge
        for part in parts
    ]
    columns = (
        np.concatenate([getattr(part, name) for part in parts])
        for name in ("centres", "along", "front", "sizes", "give", "joined")
    )
    return Rings(
        *columns,
        np.concatenate(codes),
        tuple(index),
        np.concatenate([part.squareness for part in parts]),
        np.concatenate([part.swell for part in parts]),
        np.concatenate(bulges),
        np.concatenate([_lengths(part) if part.uv is None else part.uv for part in parts]),
    )


def _lengths(part: Rings) -> Floats:
    """Texture coordinates: metres round and along."""
    count, sides = part.codes.shape
    uv = np.empty((count, sides + 1, 2))
    uv[..., 0] = np.arange(sides + 1) * (2.0 * np.pi / sides * part.sizes.max())
    step = np.diff(part.centres, axis=0)
    uv[0, :, 1] = 0.0
    uv[1:, :, 1] = np.sqrt((step * step).sum(axis=1)).cumsum()[:, None]
    return uv


def _points(rings: Rings) -> tuple[Floats, Floats]:
    """Where the points are and how they give, both of shape (N, M, 3)."""
    along = unit(rings.along)
    ahead = rings.front - np.einsum("ij,ij->i", rings.front, along)[:, None] * along
    ahead = unit(ahead)
    aside = _cross(ahead, along)
    cos, sin, corner = _circle(rings.codes.shape[1])
    out = (1.0 + rings.squareness[:, None] * corner) * rings.bulge
    half = rings.sizes
    depth = (np.where(cos >= 0, half[:, :1], half[:, 1:2]) * cos * out)[..., None] * ahead[:, None]
    breadth = (half[:, 2:] * sin * out)[..., None] * aside[:, None]
    give = rings.give[:, None] + rings.swell[:, None, None] * depth * np.array([1.0, 0.0, 0.0])
    return rings.centres[:, None] + depth + breadth, give


def _solved(points: Floats, give: Floats, target: float, low: float, high: float) -> float:
    """The looseness at which an extent, convex in it, reaches its target (Newton's method)."""
    looseness = 0.0
    if low >= high:
        return looseness
    for _ in range(8):
        moved = points + looseness * give
        first, last = moved.argmin(), moved.argmax()
        slope = give[last] - give[first]
        if slope < 1e-6:
            # The extent does not depend on the looseness here: look where it does.
            if looseness >= high:
                break
            looseness = high
            continue
        step = (target - (moved[last] - moved[first])) / slope
        looseness = float(min(max(looseness + step, low), high))
        if abs(step) < 1e-4:
            break
    return looseness


def _skin(rings: Rings, points: Floats) -> Mesh:
    joined = rings.joined
    count, sides = points.shape[:2]
    row = np.arange(count)
    before = row - joined
    after = row + np.append(joined[1:], False)
    turn = np.arange(sides)
    across = points[:, (turn + 1) % sides] - points[:, turn - 1]
    normals = unit(_cross(points[after] - points[before], across))
    pole = np.abs(across).max(axis=(1, 2)) < 1e-6
    centres = rings.centres
    outward = unit(2.0 * centres - centres[after] - centres[before])
    flat = np.abs(outward).max(axis=1) < 1e-6
    sense = np.where(after == row, 1.0, -1.0)[:, None] * unit(rings.along)
    normals[pole] = np.where(flat[:, None], sense, outward)[pole, None]
    seam = np.append(turn, 0)
    lower, upper = before[joined], row[joined]
    corner = np.arange(count * (sides + 1), dtype=np.int32).reshape(count, sides + 1)
    a, b = corner[lower, :-1], corner[upper, :-1]
    c, d = corner[upper, 1:], corner[lower, 1:]
    band = rings.codes[upper]
    wide, started = ~pole[upper], ~pole[lower]
    faces = [np.stack([a, b, c], -1)[wide], np.stack([a, c, d], -1)[started]]
    assert rings.uv is not None
    return Mesh(
        points[:, seam].reshape(-1, 3).astype(np.float32),
        normals[:, seam].reshape(-1, 3).astype(np.float32),
        rings.uv.reshape(-1, 2).astype(np.float32),
        np.concatenate([face.reshape(-1, 3) for face in faces]),
        np.concatenate([band[wide].ravel(), band[started].ravel()]),
        rings.materials,
    )


def _cross(first: Floats, second: Floats) -> Floats:
    """np.cross, several times as fast."""
    a, b, c = first[..., 0], first[..., 1], first[..., 2]
    x, y, z = second[..., 0], second[..., 1], second[..., 2]
    result = np.empty(np.broadcast_shapes(first.shape, second.shape))
    result[..., 0], result[..., 1], result[..., 2] = b * z - c * y, c * x - a * z, a * y - b * x
    return result
