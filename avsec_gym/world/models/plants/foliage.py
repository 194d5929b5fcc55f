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
    reach: tuple[float, float] = (0.68, 1.02),
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
    outward, owner = _directions(clusters, count, rng, heart, reach)
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
    clusters: Clusters, count: int, rng: np.random.Generator, heart: Floats, reach
) -> tuple[Floats, NDArray[np.intp]]:
    """Where on which cluster sprays grow (in its unit sphere): not inside another cluster."""
    height = clusters.centre[:, 2] - clusters.centre[:, 2].min()
    area = np.linalg.det(clusters.axes) ** (2 / 3) / (0.65 + 0.7 * height / height.max()) ** 2
    many = int(2.2 * count)
    owner = rng.choice(len(area), many, p=area / area.sum())
    outward = unit(rng.normal(0, 1, (many, 3)) + [0, 0, 0.2]) * rng.uniform(*reach, (many, 1))
    point = clusters.centre[owner] + _times(outward, clusters.axes[owner])
    within = (point[None] - clusters.centre[:, None]) @ np.linalg.inv(clusters.axes)
    hidden = (np.sum(within**2, axis=2) < reach[0]**2 - 0.02).any(axis=0)
    inward = np.sum(unit(point - clusters.centre[owner]) * unit(point - heart), axis=1) < -0.1
    kept = np.argsort(hidden | inward, kind="stable")[:count]
    return outward[kept], owner[kept]


def _times(vectors: Floats, matrices: Floats) -> Floats:
    """Row vectors, shape (n, 3), times matrices, shape (n, 3, 3)."""
    return np.asarray((vectors[:, None] @ matrices)[:, 0])


def unit(vectors: Floats) -> Floats:
    """Scaled to length 1 along the last axis."""
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-12))
