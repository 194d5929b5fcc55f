"""Leaves: sprays on clusters, and the shade inside them.

A crown is a set of clusters, ellipsoids of leaves at the ends of branches.  Light falls on the
crown as on a volume: normals lean towards the outside of cluster and crown, so that clusters have
a bright and a dark side however their leaves lie.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats
from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh
from avsec_gym.world.models.plants.skeleton import unit

REACH = 1.02
"""Sprays grow at most so far from their cluster's centre, relative to its half axes."""

_INNERMOST = 0.68
_TRANSLUCENT = 0.5
"""Share of the light on a leaf's far side that shines through."""
_THROUGH = 1.6
"""The sky's light reaches a leaf from behind as well; shading knows its front only."""
_INSIDE = 2.2
_TEXTURE_SIZE = 1.1


class Clusters(NamedTuple):
    """n ellipsoids."""

    centre: Floats
    """Metres, shape (n, 3)."""
    axes: Floats
    """Rows are the half axes, metres, shape (n, 3, 3)."""


def leaf_material(family: str, tone: float = 1.0, *, solid: bool = False) -> Material:
    """Leaves of a texture family (``lime`` for ``leaves_lime``).

    Args:
        family: Name of the leaves' texture.
        tone: Lightness of the leaves relative to the texture; lighter ones are yellower.
        solid: Whether no ray passes between them: the dark inside of a crown.
    """
    red, green, blue = tone**1.2, tone, tone**0.75
    if solid:
        # Light that many leaves have passed on is what remains inside: green, and not little.
        red, green, blue = (_INSIDE * light for light in (red, green, blue))
    tint = tuple(_THROUGH * light for light in (red, green, blue))
    return Material(
        f"leaves_{family}",
        (tint[0], tint[1], tint[2]),
        translucent=_TRANSLUCENT,
        infrared=0.6,
        leaves=not solid,
    )


def sprays(
    clusters: Clusters,
    count: int,
    cover: float,
    materials: tuple[Material, ...],
    rng: np.random.Generator,
    *,
    heart: Floats,
    hang: float = 0.0,
    coarsening: float = 0.0,
) -> Mesh:
    """Triangles of a few leaves each, all over the outside of a crown.

    Args:
        clusters: Clusters that bear the sprays.
        count: Number of triangles.
        cover: Area of the leaves relative to that of the clusters.
        materials: Materials of sprays from the inside of clusters to their outside.
        rng: The source of chance.
        heart: Centre of the crown, shape (3,); the crown's outside is away from it.
        hang: Attitude: at 0 sprays spread as they like, at 1 they hang straight down, at -1 they
            stand.
        coarsening: Ratio of their length at the top to that at the bottom, which a camera sees from
            near by, relative to the average.
    """
    height = clusters.centre[:, 2] - clusters.centre[:, 2].min()
    coarseness = 1.0 + coarsening * (height / max(height.max(), 1e-9) - 0.5)
    area = _surface(clusters)
    length = np.sqrt(2.1 * cover * area.sum() / count) * coarseness
    outward, owner = _places(clusters, count, area / coarseness**2, heart, rng)
    base = clusters.centre[owner] + _times(outward, clusters.axes[owner])
    swell = _normals(clusters, outward, owner)
    facing = unit(swell + 0.42 * rng.normal(0, 1, (count, 3)) + [0, 0, 0.3])
    along = rng.normal(0, 1, (count, 3)) + 0.6 * unit(base - heart)
    along = unit(along - np.sum(along * facing, axis=1, keepdims=True) * facing)
    along = unit((1 - abs(hang)) * along - [0, 0, hang])
    across = unit(np.cross(facing, along))
    facing = np.cross(along, across)
    size = (length[owner] * rng.lognormal(0, 0.22, count))[:, None]
    half = size * rng.uniform(0.15, 0.4, (count, 1)) * (1 - 0.3 * abs(hang))
    slant = size * rng.uniform(-0.35, 0.35, (count, 1))
    stalk = base - 0.45 * size * along
    corners = np.stack(
        [
            stalk + half * across - slant * along,
            base + 0.55 * size * along + 0.5 * slant * across,
            stalk - half * across + slant * along,
        ],
        axis=1,
    )
    normals = unit(0.25 * facing + 0.55 * swell + 0.4 * unit(base - heart))
    depth = (np.linalg.norm(outward, axis=1) - _INNERMOST) / (REACH - _INNERMOST)
    shade = np.clip(depth + rng.normal(0, 0.25, count), 0, 0.999)
    choice = (shade * len(materials)).astype(np.intp)
    return loose(corners, np.repeat(normals[:, None], 3, axis=1), choice, materials, rng)


def cores(
    clusters: Clusters,
    each: int,
    size: float,
    material: Material,
    rng: np.random.Generator,
    *,
    heart: Floats,
) -> Mesh:
    """The shade inside: large dark triangles inscribed in each cluster, so that it is opaque.

    Args:
        clusters: Clusters that are filled.
        each: Triangles in a cluster.
        size: Size relative to the clusters.
        material: Material of all.
        rng: The source of chance.
        heart: Centre of the crown, shape (3,); the crown's outside is away from it.
    """
    count = each * len(clusters.centre)
    owner = np.repeat(np.arange(len(clusters.centre)), each)
    pole = unit(rng.normal(0, 1, (count, 3)))
    side = unit(np.cross(pole, rng.normal(0, 1, (count, 3))))
    other = np.cross(pole, side)
    turn = np.arange(3) * (2 * np.pi / 3) + rng.uniform(-0.5, 0.5, (count, 3))
    opening = rng.uniform(0.5, 1.15, (count, 3, 1))
    ring = np.cos(turn)[..., None] * side[:, None] + np.sin(turn)[..., None] * other[:, None]
    direction = np.cos(opening) * pole[:, None] + np.sin(opening) * ring
    inside = size * rng.uniform(0.75, 1.1, (count, 3, 1)) * direction
    corners = clusters.centre[owner, None] + inside @ clusters.axes[owner]
    normals = unit(_normals(clusters, pole, owner)[:, None] + unit(corners - heart))
    return loose(corners, normals, np.zeros(count, np.intp), (material,), rng)


def loose(
    corners: Floats,
    normals: Floats,
    material: NDArray[np.intp],
    materials: tuple[Material, ...],
    rng: np.random.Generator,
) -> Mesh:
    """Triangles that share nothing; each shows some piece of its texture, undistorted.

    Args:
        corners: Corners of triangles, shape (n, 3, 3), metres.
        normals: Normals at the corners, shape (n, 3, 3).
        material: Index of each triangle's material, shape (n,).
        materials: Materials that `material` refers to.
        rng: Generator that draws the pieces.
    """
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    right = unit(first)
    along = np.sum(second * right, axis=1)
    uv = np.zeros((len(corners), 3, 2))
    uv[:, 1, 0], uv[:, 2, 0] = np.linalg.norm(first, axis=1), along
    uv[:, 2, 1] = np.linalg.norm(second - along[:, None] * right, axis=1)
    uv += rng.uniform(0, _TEXTURE_SIZE, (len(corners), 1, 2))
    return Mesh(
        corners.reshape(-1, 3).astype(np.float32),
        normals.reshape(-1, 3).astype(np.float32),
        uv.reshape(-1, 2).astype(np.float32),
        np.arange(3 * len(corners), dtype=np.int32).reshape(-1, 3),
        material.astype(np.int32),
        materials,
    )


def _places(
    clusters: Clusters, count: int, weight: Floats, heart: Floats, rng: np.random.Generator
) -> tuple[Floats, NDArray[np.intp]]:
    """Where (in the unit sphere) on which cluster sprays grow: outside of others, and outside."""
    many = int(1.8 * count)
    owner = rng.choice(len(weight), many, p=weight / weight.sum())
    outward = unit(rng.normal((0, 0, 0.2), 1, (many, 3)))
    outward *= rng.uniform(_INNERMOST, REACH, (many, 1))
    point = clusters.centre[owner] + _times(outward, clusters.axes[owner])
    offset = (point[None] - clusters.centre[:, None]).astype(np.float32)
    within = offset @ np.linalg.inv(clusters.axes).astype(np.float32)
    hidden = (np.einsum("cni,cni->cn", within, within) < 0.95 * _INNERMOST**2).any(axis=0)
    inward = np.sum(unit(point - clusters.centre[owner]) * unit(point - heart), axis=1) < -0.1
    kept = np.argsort(hidden | inward, kind="stable")[:count]
    return outward[kept], owner[kept]


def _normals(clusters: Clusters, outward: Floats, owner: NDArray[np.intp]) -> Floats:
    """Of the ellipsoids, at points of the unit sphere."""
    gradient = np.asarray(np.linalg.inv(clusters.axes).transpose(0, 2, 1), np.float64)
    return unit(_times(outward, gradient[owner]))


def _surface(clusters: Clusters) -> Floats:
    """About the area of each ellipsoid, square metres."""
    return np.asarray(4 * np.pi * np.abs(np.linalg.det(clusters.axes)) ** (2 / 3))


def _times(vectors: Floats, matrices: Floats) -> Floats:
    """Row vectors, shape (n, 3), times matrices, shape (n, 3, 3)."""
    return np.asarray((vectors[:, None] @ matrices)[:, 0])
