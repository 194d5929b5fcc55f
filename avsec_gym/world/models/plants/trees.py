"""Trees: a skeleton, clusters of leaves where its branches end, and the shade within."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.models.plants.foliage import (
    Clusters,
    cores,
    leaf_material,
    sprays,
)
from avsec_gym.world.models.plants.skeleton import grow, unit, wood
from avsec_gym.world.models.plants.species import SPECIES, Detail, Species
from avsec_gym.world.shapes import box, scattered

VARIANTS = 6
"""Variants of each species, from the smallest to the tallest."""

_TONES = (0.6, 1.1, 1.7)
_TRIES = 8
_GOLDEN_ANGLE = np.pi * (3 - 5**0.5)


class _Fineness(NamedTuple):
    triangles: int
    shade: float
    """Share of them in the dark inside of the clusters."""
    cover: float
    """Cover of the outer ones, relative to the species'."""
    sides: int
    thinnest: float


_FINENESS: dict[Detail, _Fineness] = {
    "near": _Fineness(5000, 0.16, 0.72, 9, 0.012),
    "middle": _Fineness(1500, 0.26, 0.6, 6, 0.06),
    "far": _Fineness(400, 0.45, 0.5, 4, 9.0),
}


@cache
def tree(species: str, variant: int, detail: Detail) -> Mesh:
    """A tree on the origin: a prototype to be placed many times, turned and scaled.

    Args:
        species: A key of `SPECIES`.
        variant: Number of the skeleton, 0 to `VARIANTS` - 1; a higher one is also taller.
        detail: Level of detail: at most 5,000 triangles near, 1,500 in the middle, 400 far; the
            same shape.

    Raises:
        KeyError: There is no such species.
    """
    kind = SPECIES[species]
    seed = (list(SPECIES).index(species), variant)
    rng = np.random.default_rng(seed)
    low, high = kind.heights
    height = low + (high - low) * (variant + 0.5) / VARIANTS
    trunk = _trunk(kind, height, rng)
    clusters = (_fronds if kind.whorled else _crown)(kind, height, trunk, rng)
    heart = np.array([*clusters.centre[:, :2].mean(axis=0), height * (0.35 + 0.5 * kind.clear)])
    skeleton = grow(trunk, clusters.centre, kind.girth * height)
    fine = _FINENESS[detail]
    parts = [wood(skeleton, kind.bark, sides=fine.sides, thinnest=fine.thinnest)]
    if kind.staked and detail != "far":
        parts.append(_stakes())
    if kind.shade > 0:
        size = kind.shade * (1.0 if detail == "near" else 1.12)
        dark = leaf_material(kind.leaves, 0.32 * kind.brightness, solid=True)
        each = int(fine.shade * fine.triangles / kind.clusters)
        parts.append(cores(clusters, each, size, dark, rng, heart=heart))
    tones = tuple(leaf_material(kind.leaves, tone * kind.brightness) for tone in _TONES)
    rest = fine.triangles - sum(len(part.faces) for part in parts)
    leaves = sprays(
        clusters,
        rest,
        fine.cover * kind.cover,
        tones,
        rng,
        heart=heart,
        hang=kind.hang,
        coarsening=0.7 if detail == "near" else 0.3,
    )
    parts.append(leaves)
    whole = merge(parts)
    np.maximum(whole.vertices[:, 2], 0.0, out=whole.vertices[:, 2])
    stretch = height / float(whole.bounds[1][2])
    return whole.scaled(stretch, stretch, stretch)


def _trunk(kind: Species, height: float, rng: np.random.Generator) -> Floats:
    """From the ground to the end of the leader, shape (10, 3): nearly straight."""
    top = height * (kind.clear + kind.leader * (1 - kind.clear)) * 0.97
    step = rng.normal(0, 0.006 * height, (10, 2))
    sway = np.cumsum(step, axis=0) * np.linspace(0, 1, 10)[:, None]
    return np.column_stack([sway, np.linspace(0, top, 10)])


def _crown(kind: Species, height: float, trunk: Floats, rng: np.random.Generator) -> Clusters:
    """Clusters that fill the species' outline, with dents and bulges, apart from each other."""
    bottom, radius = kind.clear * height, kind.spread * height
    count = kind.clusters
    level = rng.random((count, _TRIES))
    azimuth = rng.uniform(0, 2 * np.pi, (count, _TRIES))
    bulge, phase = rng.normal(0, 0.1, 2), rng.uniform(0, 2 * np.pi, 2)
    share = _width(kind, level) * (
        1
        + bulge[0] * np.sin(azimuth + phase[0])
        + bulge[1] * np.sin(2 * azimuth + 5 * level + phase[1])
    )
    size = kind.cluster * radius * rng.uniform(0.7, 1.2, (count, 1)) * (0.55 + 0.45 * share)
    half_height = size * kind.flatness
    reach = np.maximum(share * radius - 0.8 * size, 0) * rng.random((count, _TRIES)) ** 0.3
    z = bottom + level * (height - bottom - half_height) + 0.5 * half_height
    out = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1)
    candidates = np.dstack([_axis(trunk, z) + reach[..., None] * out, z])
    # One after the other takes that of its candidates which is farthest from those before it.
    chosen = np.zeros(count, np.intp)
    centre = candidates[:, 0].copy()
    for number in range(1, count):
        away = (candidates[number, :, None] - centre[:number]) / [1, 1, kind.flatness]
        chosen[number] = np.argmax(np.linalg.norm(away, axis=2).min(axis=1))
        centre[number] = candidates[number, chosen[number]]
    size = size[np.arange(count), chosen]
    tilt = np.linalg.qr(np.eye(3) + 0.25 * rng.normal(0, 1, (count, 3, 3)))[0]
    return Clusters(centre, size[:, None, None] * np.diag([1, 1, kind.flatness]) @ tilt)


def _fronds(kind: Species, height: float, trunk: Floats, rng: np.random.Generator) -> Clusters:
    """Flat drooping fronds that spiral up the trunk, each a long cluster."""
    count = kind.clusters
    bottom, radius = kind.clear * height, kind.spread * height
    level = 1 - (1 - np.arange(count) / count) ** 0.8
    azimuth = _GOLDEN_ANGLE * np.arange(count) + rng.normal(0, 0.3, count)
    length = radius * _width(kind, level)
    length = (length * rng.uniform(0.8, 1.15, count))[:, None]
    z = bottom + level * (height - bottom) * 0.97
    slope = np.interp(level, [0, 0.6, 1], [-0.45, -0.15, 0.8])
    out = np.column_stack([np.cos(azimuth), np.sin(azimuth), slope])
    side = np.column_stack([-np.sin(azimuth), np.cos(azimuth), 0 * azimuth])
    upwards = unit(np.cross(out, side))
    centre = np.column_stack([_axis(trunk, z), z]) + 0.5 * length * out
    centre[:, 2] = np.maximum(centre[:, 2], 0.25 * length[:, 0])
    axes = np.stack([0.56 * length * out, 0.36 * length * side, 0.16 * length * upwards], axis=1)
    return Clusters(centre, axes)


def _width(kind: Species, level: Floats) -> Floats:
    """Of the crown at heights within it, relative to its greatest."""
    heights, widths = np.array(kind.outline).T
    return np.asarray(np.interp(level, heights, widths))


def _axis(trunk: Floats, z: Floats) -> Floats:
    """Where the trunk is at heights of any shape, x and y along the last axis."""
    return np.stack([np.interp(z, trunk[:, 2], trunk[:, i]) for i in (0, 1)], axis=-1)


def _stakes() -> Mesh:
    """Three posts round the trunk and the rails that join them."""
    timber = Material("bark_rough/0", (1.6, 1.45, 1.2))
    angle = np.arange(3) * (2 * np.pi / 3)
    between = angle + np.pi / 3
    zero = np.zeros(3)
    posts = np.column_stack([0.4 * np.cos(angle), 0.4 * np.sin(angle), zero, angle])
    rails = np.column_stack([0.2 * np.cos(between), 0.2 * np.sin(between), zero + 1.7, between])
    return merge(
        [
            scattered([box(0.07, 0.07, 1.9, timber, top=timber)], posts),
            scattered([box(0.03, 0.7, 0.08, timber, top=timber)], rails),
        ]
    )
