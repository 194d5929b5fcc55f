"""Trees: a skeleton, clusters of leaves where its branches end, and the shade within."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.models.plants.foliage import (
    Clusters,
    cores,
    leaf_material,
    sprays,
    unit,
)
from avsec_gym.world.models.plants.skeleton import grow, wood
from avsec_gym.world.models.plants.species import SPECIES, Detail, Species
from avsec_gym.world.shapes import box, scattered

Floats = NDArray[np.float64]

VARIANTS = 4
"""Of each species, from the smallest to the tallest."""

_TONES = (0.4, 0.95, 1.5)
_GOLDEN_ANGLE = np.pi * (3 - 5**0.5)


class _Fineness(NamedTuple):
    triangles: int
    shade: int
    """Inner triangles of a cluster."""
    cover: float
    """Of the outer ones, relative to the species'."""
    sides: int
    thinnest: float


_FINENESS: dict[Detail, _Fineness] = {
    "near": _Fineness(5000, 16, 1.0, 9, 0.012),
    "middle": _Fineness(1500, 11, 0.6, 6, 0.06),
    "far": _Fineness(400, 5, 0.5, 4, 9.0),
}


@cache
def tree(species: str, variant: int, detail: Detail) -> Mesh:
    """A tree on the origin: a prototype to be placed many times, turned and scaled.

    Args:
        species: A key of `SPECIES`.
        variant: 0 to `VARIANTS` - 1: another skeleton, and taller.
        detail: At most 5,000 triangles near, 1,500 in the middle, 400 far; the same shape.

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
        dark = leaf_material(kind.leaves, 0.22 * kind.brightness)
        parts.append(cores(clusters, fine.shade, size, dark, rng, heart=heart))
    tones = tuple(leaf_material(kind.leaves, tone * kind.brightness) for tone in _TONES)
    rest = fine.triangles - sum(len(part.faces) for part in parts)
    leaves = sprays(
        *(clusters, rest, fine.cover * kind.cover, tones, rng),
        heart=heart,
        hang=kind.hang,
        coarsening=0.7,
    )
    parts.append(leaves)
    whole = merge(parts)
    stretch = height / float(whole.bounds[1][2])
    return whole.scaled(stretch, stretch, stretch)


def _trunk(kind: Species, height: float, rng: np.random.Generator) -> Floats:
    """From the ground to the end of the leader, shape (10, 3): nearly straight."""
    top = height * (kind.clear + kind.leader * (1 - kind.clear)) * 0.97
    z = np.linspace(0, top, 10)
    sway = np.cumsum(rng.normal(0, 0.006 * height, (10, 2)), axis=0) * np.linspace(0, 1, 10)[:, None]
    return np.column_stack([sway, z])


def _crown(kind: Species, height: float, trunk: Floats, rng: np.random.Generator) -> Clusters:
    """Clusters apart from each other that fill the species' outline, with dents and bulges."""
    bottom, radius = kind.clear * height, kind.spread * height
    count, tries = kind.lumps, 8
    level, azimuth = rng.random((count, tries)), rng.uniform(0, 2 * np.pi, (count, tries))
    bulge = rng.normal(0, 1, 4)
    share = np.interp(level, *zip(*kind.outline, strict=True)) * (
        1
        + 0.1 * bulge[0] * np.sin(azimuth + 6 * bulge[1])
        + 0.1 * bulge[2] * np.sin(2 * azimuth + 5 * level + 6 * bulge[3])
    )
    size = kind.lump * radius * rng.uniform(0.7, 1.2, (count, 1)) * (0.55 + 0.45 * share)
    reach = np.maximum(share * radius - 0.8 * size, 0) * rng.random((count, tries)) ** 0.3
    z = bottom + level * (height - bottom - size * kind.flatness) + 0.5 * size * kind.flatness
    axis = np.stack([np.interp(z, trunk[:, 2], trunk[:, i]) for i in (0, 1)], axis=-1)
    flat = axis + reach[..., None] * np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1)
    candidates = np.concatenate([flat, z[..., None]], axis=-1)
    chosen = np.zeros(count, np.intp)
    centre = candidates[:, 0].copy()
    for number in range(1, count):
        apart = np.linalg.norm(
            (candidates[number, :, None] - centre[None, :number]) / [1, 1, kind.flatness], axis=2
        )
        chosen[number] = np.argmax(apart.min(axis=1))
        centre[number] = candidates[number, chosen[number]]
    size = size[np.arange(count), chosen]
    axes = size[:, None, None] * np.diag([1.0, 1.0, kind.flatness])
    tilt = np.linalg.qr(np.eye(3) + 0.25 * rng.normal(0, 1, (count, 3, 3)))[0]
    return Clusters(centre, axes @ tilt)


def _fronds(kind: Species, height: float, trunk: Floats, rng: np.random.Generator) -> Clusters:
    """Flat drooping fronds, spiralling up the trunk."""
    count = kind.lumps
    bottom, radius = kind.clear * height, kind.spread * height
    level = 1 - (1 - np.arange(count) / count) ** 0.8
    azimuth = _GOLDEN_ANGLE * np.arange(count) + rng.normal(0, 0.3, count)
    length = radius * np.interp(level, *zip(*kind.outline, strict=True)) * rng.uniform(0.8, 1.15, count)
    z = bottom + level * (height - bottom) * 0.97
    slope = np.interp(level, [0, 0.6, 1], [-0.45, -0.15, 0.8])
    out = np.stack([np.cos(azimuth), np.sin(azimuth), slope], axis=1)
    side = np.stack([-np.sin(azimuth), np.cos(azimuth), 0 * azimuth], axis=1)
    up = unit(np.cross(out, side))
    axis = np.stack([np.interp(z, trunk[:, 2], trunk[:, i]) for i in (0, 1)], axis=-1)
    centre = np.column_stack([axis, z]) + 0.5 * length[:, None] * out
    axes = np.stack(
        [0.56 * length[:, None] * out, 0.36 * length[:, None] * side, 0.16 * length[:, None] * up], axis=1
    )
    return Clusters(centre, axes)


def _stakes() -> Mesh:
    """Three posts and the rails that join them."""
    timber = Material("bark_rough/0", (1.6, 1.45, 1.2))
    angle = np.arange(3) * (2 * np.pi / 3)
    posts = np.column_stack([0.4 * np.cos(angle), 0.4 * np.sin(angle), 0 * angle, angle])
    rails = np.column_stack([0.2 * np.cos(angle + np.pi / 3), 0.2 * np.sin(angle + np.pi / 3), 0 * angle + 1.7, angle - np.pi/6 ])
    return merge(
        [
            scattered([box(0.07, 0.07, 1.9, timber, top=timber)], posts),
            scattered([box(0.03, 0.7, 0.08, timber)], rails),
        ]
    )

