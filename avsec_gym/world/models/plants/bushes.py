"""Bushes, clipped hedges, and ivy on walls."""

from __future__ import annotations

from functools import cache

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.models.plants.foliage import (
    Clusters,
    cores,
    leaf_material,
    loose,
    sprays,
)
from avsec_gym.world.models.plants.skeleton import unit
from avsec_gym.world.models.plants.species import Detail
from avsec_gym.world.shapes import box

BUSHES = 9
"""Variants of `bush`: 0.9 to 2.6 m high."""

HEDGES = 6
"""Variants of `hedge` that scenes use."""

_BUSH_TRIANGLES: dict[Detail, int] = {"near": 1500, "middle": 700, "far": 250}
_HEDGE_SPRAYS = 110
"""Hedge sprays for each square metre."""
_HEDGE_TRIANGLES = 5000
_HEDGE_SHARE: dict[Detail, float] = {"near": 1.0, "middle": 0.5, "far": 0.2}


@cache
def bush(variant: int, detail: Detail = "near") -> Mesh:
    """A free-standing shrub on the origin, leafy to the ground: a prototype.

    Args:
        variant: Number of the shape, 0 to `BUSHES` - 1, from low and broad to tall.
        detail: 1,500 triangles near, 700 in the middle, 250 far; the same shape.
    """
    rng = np.random.default_rng((101, variant))
    height = 0.9 + 1.7 * variant / (BUSHES - 1)
    radius = height * rng.uniform(0.45, 0.75)
    count = 10 + 2 * variant
    azimuth = 2.4 * np.arange(count) + rng.normal(0, 0.3, count)
    level = np.linspace(0, 1, count) ** 1.3
    size = radius * rng.uniform(0.35, 0.55, count)
    reach = np.maximum((radius - size) * np.sqrt(1 - 0.7 * level**2) * rng.random(count) ** 0.4, 0)
    z = 0.45 * size + level * (height - 1.3 * size)
    centre = np.column_stack([reach * np.cos(azimuth), reach * np.sin(azimuth), z])
    clusters = Clusters(centre, size[:, None, None] * np.diag([1.0, 1.0, 0.85]))
    heart = np.array([0.0, 0.0, 0.3 * height])
    family = ("shrub", "fruit", "maple", "hedge", "shrub", "lime")[variant % 6]
    dark = leaf_material(family, 0.32, solid=True)
    tones = [leaf_material(family, tone) for tone in (0.7, 1.1, 1.5)]
    inside = cores(clusters, 16 if detail == "near" else 6, 0.8, dark, rng, heart=heart)
    rest = _BUSH_TRIANGLES[detail] - len(inside.faces)
    leaves = sprays(clusters, rest, 0.4, tuple(tones), rng, heart=heart, hang=0.1)
    whole = merge([inside, leaves])
    whole.vertices[:, 2] = np.maximum(whole.vertices[:, 2], 0.0)
    low, high = whole.bounds
    length, width, _ = (high - low).tolist()
    return whole.fitted(length, width, height)


def hedge(
    length: float, height: float, depth: float, variant: int = 0, detail: Detail = "near"
) -> Mesh:
    """A clipped hedge along x: a dark box behind leaves that stand out here and there.

    Args:
        length: Length of the hedge, metres.
        height: Height of the hedge, metres.
        depth: Depth of the hedge, metres.
        variant: Other leaves at other places; even ones are privet, odd ones a darker shrub.
        detail: Half the leaves in the middle, a fifth far away, larger instead.

    Returns:
        A mesh that fills its box exactly, at most 5,000 triangles.
    """
    rng = np.random.default_rng((102, variant))
    family = "hedge" if variant % 2 == 0 else "shrub"
    size = np.array([length, depth, height])
    shaggy = min(0.07, 0.2 * depth)
    areas = np.array([depth * height, depth * height, *[length * height] * 2, length * depth])
    count = int(min(_HEDGE_SPRAYS * areas.sum(), _HEDGE_TRIANGLES - 300) * _HEDGE_SHARE[detail])
    outward = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]], float)
    facing = outward[rng.choice(5, count, p=areas / areas.sum())]
    place = np.where(facing != 0, 0.5 * facing, rng.uniform(-0.5, 0.5, (count, 3)))
    place = place * (size - 2 * shaggy) + facing * rng.uniform(-0.3, 0.7, (count, 1)) * shaggy
    spread = 0.75 * np.sqrt(areas.sum() / count)
    corners = place[:, None] + rng.normal(0, 0.5, (count, 3, 3)) * spread
    swell = 0.5 * np.sin(place @ [[2.1, 0.7, 1.3], [1.1, 2.9, 0.4], [0.9, 1.6, 2.7]] * 1.7)
    normals = unit(facing + 0.35 * swell + 0.25 * rng.normal(0, 1, (count, 3)))
    limit = 0.5 * size
    corners = np.clip(corners, -limit, limit)
    tones = tuple(leaf_material(family, tone) for tone in (0.7, 1.0, 1.35))
    dark = leaf_material(family, 0.35, solid=True)
    leaves = loose(
        _turned_outside(corners, normals),
        np.repeat(normals[:, None], 3, axis=1),
        rng.integers(3, size=count),
        tones,
        rng,
    )
    less = 2.4 * shaggy
    inside = box(length - less, depth - less, height - 0.5 * less, dark, top=dark)
    whole = merge([inside, leaves.placed(0.0, 0.0, 0.5 * height)])
    return whole.fitted(length, depth, height)


def ivy(width: float, height: float, variant: int = 0) -> Mesh:
    """Climbing leaves on a wall: the wall is the plane x = 0, its outside x > 0.

    Args:
        width: Width along y, metres.
        height: The highest shoots, metres.
        variant: Another course.

    Returns:
        At most 2,500 triangles, thickest at the ground in the middle.
    """
    rng = np.random.default_rng((103, variant))
    many = int(min(260 * width * height, 5000))
    side, level = rng.uniform(-0.5, 0.5, many), rng.random(many)
    waves = rng.uniform(0, 2 * np.pi, 3)
    top = 0.7 + 0.15 * np.sin(7 * side + waves[0]) + 0.15 * np.sin(17 * side + waves[1])
    edge = 0.42 + 0.08 * np.sin(9 * level + waves[2])
    kept = (level < top * (1 - (side / 0.5) ** 4)) & (np.abs(side) < edge)
    side, level = side[kept][:2500], level[kept][:2500]
    count = len(side)
    depth = rng.uniform(0.02, 0.16, count) * (1.1 - level)
    place = np.column_stack([depth, side * width, level * height])
    corners = place[:, None] + rng.normal(0, 1, (count, 3, 3)) * [0.03, 0.1, 0.1]
    corners[..., 0] = np.maximum(corners[..., 0], 0.005)
    corners[..., 2] = np.maximum(corners[..., 2], 0.0)
    normals = unit(np.array([1.0, 0, 0.35]) + 0.3 * rng.normal(0, 1, (count, 3)))
    tones = tuple(leaf_material("ivy", tone) for tone in (0.8, 1.0, 1.2))
    return loose(
        _turned_outside(corners, normals),
        np.repeat(normals[:, None], 3, axis=1),
        rng.integers(3, size=count),
        tones,
        rng,
    )


def _turned_outside(corners: Floats, normals: Floats) -> Floats:
    """Triangles, shape (n, 3, 3), whose order of corners agrees with the normals."""
    facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    wrong = np.sum(facing * normals, axis=1) < 0
    return np.where(wrong[:, None, None], corners[:, ::-1], corners)
