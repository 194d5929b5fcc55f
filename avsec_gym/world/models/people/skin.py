"""Rings become a mesh that fills a box.

To fill a given box, a body does not stretch: its rings move apart (a longer stride, elbows farther
out, a longer wheelbase) while they keep their size.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.models.people.rings import Rings, unit

LoosenessLimits = tuple[tuple[float, float], tuple[float, float], tuple[float, float]]


def filling(
    parts: Sequence[Rings],
    dimensions: tuple[float, float, float],
    limits: LoosenessLimits = ((-0.7, 1.3), (-0.12, 0.3), (0.0, 0.0)),
) -> Mesh:
    """The parts as a mesh that fills a box: loosened as far as allowed, stretched for the rest.

    Args:
        parts: The parts, at least one.
        dimensions: Height, width, length, metres.
        limits: Least and greatest looseness along x, y and z.
    """
    height, width, length = dimensions
    groups = grouped(parts)
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


def grouped(parts: Sequence[Rings]) -> list[Rings]:
    """All parts with equally many points in a ring as one."""
    sizes = sorted({part.codes.shape[1] for part in parts})
    return [_joined([part for part in parts if part.codes.shape[1] == size]) for size in sizes]


def surface(parts: Sequence[Rings]) -> Mesh:
    """The parts as one smooth mesh, where they are."""
    return merge([_skin(group, _points(group)[0]) for group in grouped(parts)])


def _joined(parts: Sequence[Rings]) -> Rings:
    index: dict[Material, int] = {}
    codes = []
    for part in parts:
        numbers = [index.setdefault(material, len(index)) for material in part.materials]
        codes.append(np.array(numbers, np.int32)[part.codes])
    bulges = [np.ones(part.codes.shape) if part.bulge is None else part.bulge for part in parts]
    return Rings(
        centres=np.concatenate([part.centres for part in parts]),
        along=np.concatenate([part.along for part in parts]),
        front=np.concatenate([part.front for part in parts]),
        sizes=np.concatenate([part.sizes for part in parts]),
        give=np.concatenate([part.give for part in parts]),
        joined=np.concatenate([part.joined for part in parts]),
        codes=np.concatenate(codes),
        materials=tuple(index),
        squareness=np.concatenate([part.squareness for part in parts]),
        swell=np.concatenate([part.swell for part in parts]),
        bulge=np.concatenate(bulges),
        uv=np.concatenate([_lengths(part) if part.uv is None else part.uv for part in parts]),
    )


def _lengths(part: Rings) -> Floats:
    """Texture coordinates: metres round both sides from the front, and along."""
    count, sides = part.codes.shape
    turn = np.arange(sides + 1)
    uv = np.empty((count, sides + 1, 2))
    # Mirrored left and right, as clothes are, so that there is no seam.
    uv[..., 0] = np.minimum(turn, sides - turn) * (2.0 * np.pi / sides * part.sizes.max())
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
    out = 1.0 + rings.squareness[:, None] * corner
    if rings.bulge is not None:
        out = out * rings.bulge
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
    return Mesh(
        points[:, seam].reshape(-1, 3).astype(np.float32),
        normals[:, seam].reshape(-1, 3).astype(np.float32),
        np.asarray(rings.uv, np.float32).reshape(-1, 2),
        np.concatenate([face.reshape(-1, 3) for face in faces]),
        np.concatenate([band[wide].ravel(), band[started].ravel()]),
        rings.materials,
    )


@functools.cache
def _circle(sides: int) -> tuple[Floats, Floats, Floats]:
    """Cosines, sines, and how much farther out a square is than its circle."""
    angle = np.linspace(0.0, 2.0 * np.pi, sides, endpoint=False)
    cos, sin = np.cos(angle), np.sin(angle)
    return cos, sin, 1.0 / np.maximum(np.abs(cos), np.abs(sin)) - 1.0


def _cross(first: Floats, second: Floats) -> Floats:
    """np.cross, several times as fast."""
    a, b, c = first[..., 0], first[..., 1], first[..., 2]
    x, y, z = second[..., 0], second[..., 1], second[..., 2]
    result = np.empty(np.broadcast_shapes(first.shape, second.shape))
    result[..., 0], result[..., 1], result[..., 2] = b * z - c * y, c * x - a * z, a * y - b * x
    return result
