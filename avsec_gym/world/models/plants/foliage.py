"""Leaves: sprays on clusters, and the shade inside them.

A crown is a set of clusters, ellipsoids of leaves at the ends of branches.  The light falls on
the crown as on a volume: the normals of the sprays lean towards the outside of their cluster and
of the crown, so that clusters have a bright and a dark side however their sprays lie.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Float32s, Mesh

Floats = NDArray[np.float64]

TRANSLUCENT = 0.35
"""Of leaves."""
INFRARED = 0.6
"""Reflectance of leaves for LiDAR."""

_TEXTURE_SIZE = 1.1
_GOLDEN = (1 + 5**0.5) / 2
_ICOSAHEDRON = np.array(
    [
        *[(-1, _GOLDEN, 0), (1, _GOLDEN, 0), (-1, -_GOLDEN, 0), (1, -_GOLDEN, 0)],
        *[(0, -1, _GOLDEN), (0, 1, _GOLDEN), (0, -1, -_GOLDEN), (0, 1, -_GOLDEN)],
        *[(_GOLDEN, 0, -1), (_GOLDEN, 0, 1), (-_GOLDEN, 0, -1), (-_GOLDEN, 0, 1)],
    ]
) / np.hypot(1, _GOLDEN)
_ICOSAHEDRON_FACES = np.array(
    [
        *[(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11)],
        *[(1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6), (7, 1, 8)],
        *[(3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9)],
        *[(4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)],
    ]
)
_OCTAHEDRON = np.array([(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)])
_OCTAHEDRON_FACES = np.array(
    [
        *[(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4)],
        *[(2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)],
    ]
)


class Clusters(NamedTuple):
    """n ellipsoids."""

    centre: Floats
    """Metres, shape (n, 3)."""
    axes: Floats
    """Rows are the half axes, metres, shape (n, 3, 3)."""


def sprays(
    clusters: Clusters,
    count: int,
    length: float,
    materials: tuple[Material, ...],
    rng: np.random.Generator,
    *,
    hang: float,
    heart: Floats,
) -> Mesh:
    """Triangles of leaves all over the clusters' outsides.

    Args:
        clusters: Which bear them.
        count: Of triangles.
        length: Of a triangle on average, metres.
        materials: One is drawn for each cluster.
        rng: The source of chance.
        hang: See `Species.hang`.
        heart: Shape (3,); the crown's outside is away from it.
    """
    outward, owner = _directions(clusters, count, rng, heart)
    base = clusters.centre[owner] + _times(outward, clusters.axes[owner])
    inverse = np.linalg.inv(clusters.axes)
    cluster_normal = unit(_times(outward, inverse.transpose(0, 2, 1)[owner]))
    crown_normal = unit(base - heart)
    facing = unit(cluster_normal + 0.42 * rng.normal(0, 1, (count, 3)) + [0, 0, 0.3])
    along = rng.normal(0, 1, (count, 3)) + 0.6 * crown_normal
    along = unit(along - np.sum(along * facing, axis=1, keepdims=True) * facing)
    along = unit((1 - abs(hang)) * along - [0, 0, hang])
    across = unit(np.cross(facing, along))
    facing = np.cross(along, across)
    height = base[:, 2] - base[:, 2].min()
    size = (length * (0.65 + 0.7 * height / height.max()) * rng.lognormal(0, 0.22, count))[:, None]
    half = size * rng.uniform(0.15, 0.4, (count, 1)) * (1 - 0.3 * abs(hang))
    slant = size * rng.uniform(-0.35, 0.35, (count, 1))
    stalk = base - 0.45 * size * along
    corners = np.stack(
        [
            stalk - half * across + slant * along,
            base + 0.55 * size * along + 0.5 * slant * across,
            stalk + half * across - slant * along,
        ],
        axis=1,
    )
    normals = unit(0.25 * facing + 0.55 * cluster_normal + 0.4 * crown_normal)
    choice = rng.integers(len(materials), size=len(clusters.centre))[owner]
    return Mesh(
        corners[:, ::-1].reshape(-1, 3).astype(np.float32),
        np.repeat(normals, 3, axis=0).astype(np.float32),
        _flat_uv(corners, rng),
        np.arange(3 * count, dtype=np.int32).reshape(-1, 3),
        choice.astype(np.int32),
        materials,
    )


def cores(
    clusters: Clusters,
    size: float,
    material: Material,
    rng: np.random.Generator,
    *,
    heart: Floats,
    coarse: bool,
) -> Mesh:
    """The opaque inside of clusters: rough lumps, 20 triangles each (8 if coarse).

    Args:
        clusters: One lump in each.
        size: Relative to the clusters.
        material: Of the lumps.
        rng: The source of chance.
        heart: Shape (3,); the crown's outside is away from it.
        coarse: For plants far away.
    """
    shape = _OCTAHEDRON if coarse else _ICOSAHEDRON
    faces = _OCTAHEDRON_FACES if coarse else _ICOSAHEDRON_FACES
    count = len(clusters.centre)
    radius = size * rng.uniform(0.8, 1.1, (count, len(shape), 1))
    points = clusters.centre[:, None] + (radius * shape) @ clusters.axes
    outward = unit(points - clusters.centre[:, None])
    normals = unit(outward + unit(points - heart))[:, faces].reshape(-1, 3)
    corners = points[:, faces].reshape(-1, 3, 3)
    return Mesh(
        corners.reshape(-1, 3).astype(np.float32),
        normals.astype(np.float32),
        _flat_uv(corners, rng),
        np.arange(3 * len(corners), dtype=np.int32).reshape(-1, 3),
        np.zeros(len(corners), np.int32),
        (material,),
    )


def _flat_uv(corners: Floats, rng: np.random.Generator) -> Float32s:
    """Each triangle shows some piece of the texture, undistorted; corners of shape (n, 3, 3)."""
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    right = unit(first)
    across = np.sum(second * right, axis=1)
    down = np.linalg.norm(second - across[:, None] * right, axis=1)
    start = rng.uniform(0, _TEXTURE_SIZE, (len(corners), 1, 2))
    offset = np.zeros((len(corners), 3, 2))
    offset[:, 1, 0], offset[:, 2, 0] = np.linalg.norm(first, axis=1), across
    offset[:, 2, 1] = down
    return (start + offset).reshape(-1, 2).astype(np.float32)


def _directions(
    clusters: Clusters, count: int, rng: np.random.Generator, heart: Floats
) -> tuple[Floats, NDArray[np.intp]]:
    """Where on which cluster sprays grow (in its unit sphere): not inside another cluster."""
    height = clusters.centre[:, 2] - clusters.centre[:, 2].min()
    area = np.linalg.det(clusters.axes) ** (2 / 3) / (0.65 + 0.7 * height / height.max()) ** 2
    many = int(2.2 * count)
    owner = rng.choice(len(area), many, p=area / area.sum())
    outward = unit(rng.normal(0, 1, (many, 3)) + [0, 0, 0.2]) * rng.uniform(0.68, 1.02, (many, 1))
    point = clusters.centre[owner] + _times(outward, clusters.axes[owner])
    within = (point[None] - clusters.centre[:, None]) @ np.linalg.inv(clusters.axes)
    hidden = (np.sum(within**2, axis=2) < 0.44).any(axis=0)
    inward = np.sum(unit(point - clusters.centre[owner]) * unit(point - heart), axis=1) < -0.1
    kept = np.argsort(hidden | inward, kind="stable")[:count]
    return outward[kept], owner[kept]


def _times(vectors: Floats, matrices: Floats) -> Floats:
    """Row vectors, shape (n, 3), times matrices, shape (n, 3, 3)."""
    return np.asarray((vectors[:, None] @ matrices)[:, 0])


def unit(vectors: Floats) -> Floats:
    """Scaled to length 1 along the last axis."""
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-12))
