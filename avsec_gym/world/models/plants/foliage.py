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
    """Folded kites of leaves all over the clusters' outsides, two triangles each.

    Args:
        clusters: Which bear them.
        count: Of sprays.
        length: Of a spray on average, metres.
        materials: One is drawn for each cluster.
        rng: The source of chance.
        hang: See `Species.hang`.
        heart: Shape (3,); the crown's outside is away from it.
    """
    outward, owner = _directions(clusters, count, rng)
    base = clusters.centre[owner] + np.einsum("ni,nij->nj", outward, clusters.axes[owner])
    inverse = np.linalg.inv(clusters.axes)
    cluster_normal = unit(np.einsum("nij,nj->ni", inverse[owner], outward))
    crown_normal = unit(base - heart)
    facing = unit(cluster_normal + 0.5 * rng.normal(0, 1, (count, 3)) + [0, 0, 0.35])
    along = rng.normal(0, 1, (count, 3)) + 0.5 * crown_normal
    along = unit(along - np.sum(along * facing, axis=1, keepdims=True) * facing)
    along = unit((1 - abs(hang)) * along - [0, 0, hang])
    across = unit(np.cross(facing, along))
    facing = np.cross(along, across)
    size = (length * rng.lognormal(0, 0.3, count))[:, None]
    half = size * rng.uniform(0.28, 0.42, (count, 1)) * (1 - 0.35 * abs(hang))
    fold = size * rng.uniform(-0.2, 0.05, (count, 1))
    middle = base + 0.08 * size * facing
    corners = np.stack(
        [
            middle - 0.5 * size * along,
            middle + 0.1 * size * along - half * across + fold * facing,
            middle + 0.5 * size * along,
            middle + 0.1 * size * along + half * across + fold * facing,
        ],
        axis=1,
    )
    normals = unit(0.3 * facing + 0.45 * cluster_normal + 0.45 * crown_normal)
    uv = rng.uniform(0, _TEXTURE_SIZE, (count, 1, 2)) + np.stack(
        [
            np.concatenate([0 * half, -half, 0 * half, half], 1),
            np.concatenate([-0.5 * size, 0.1 * size, 0.5 * size, 0.1 * size], 1),
        ],
        axis=-1,
    )
    first = 4 * np.arange(count)[:, None, None]
    faces = (first + np.array([[0, 2, 1], [0, 3, 2]])).reshape(-1, 3)
    choice = rng.integers(len(materials), size=len(clusters.centre))[owner]
    return Mesh(
        corners.reshape(-1, 3).astype(np.float32),
        np.repeat(normals, 4, axis=0).astype(np.float32),
        uv.reshape(-1, 2).astype(np.float32),
        faces.astype(np.int32),
        np.repeat(choice, 2).astype(np.int32),
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
    radius = size * rng.uniform(0.75, 1.15, (count, len(shape), 1))
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
    clusters: Clusters, count: int, rng: np.random.Generator
) -> tuple[Floats, NDArray[np.intp]]:
    """Where on which cluster sprays grow (in its unit sphere): not inside another cluster."""
    surface = np.linalg.det(clusters.axes) ** (2 / 3)
    owner = rng.choice(len(surface), 3 * count, p=surface / surface.sum())
    outward = unit(rng.normal(0, 1, (3 * count, 3)) + [0, 0, 0.2])
    outward *= rng.uniform(0.86, 1.06, (3 * count, 1))
    point = clusters.centre[owner] + np.einsum("ni,nij->nj", outward, clusters.axes[owner])
    inverse = np.linalg.inv(clusters.axes)
    offset = point[:, None] - clusters.centre[None]
    within = np.einsum("nci,cij->ncj", offset, inverse)
    hidden = (np.sum(within**2, axis=2) < 0.65).any(axis=1)
    kept = np.argsort(hidden, kind="stable")[:count]
    return outward[kept], owner[kept]


def unit(vectors: Floats) -> Floats:
    """Scaled to length 1 along the last axis."""
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-12))
