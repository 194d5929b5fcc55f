"""Tables before a café, and plants in pots."""

from __future__ import annotations

import numpy as np

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.models.furniture.facets import facets
from avsec_gym.world.models.furniture.materials import (
    ALUMINIUM,
    CAST_IRON,
    RAW_CONCRETE,
    SOIL,
    WOOD,
    painted,
)
from avsec_gym.world.models.furniture.poles import pole
from avsec_gym.world.models.furniture.sweep import copies
from avsec_gym.world.models.furniture.variants import variants
from avsec_gym.world.shapes import box, ellipsoid, grid, polygon, revolve, tube

_CLOTHS = (
    (0.75, 0.04, 0.03),
    (0.8, 0.74, 0.6),
    (0.05, 0.18, 0.1),
    (0.85, 0.85, 0.83),
    (0.8, 0.5, 0.05),
)
_FLOWERS = (
    (0.75, 0.05, 0.06),
    (0.85, 0.3, 0.4),
    (0.85, 0.6, 0.05),
    (0.5, 0.15, 0.5),
    (0.85, 0.85, 0.85),
)


@variants(5)
def cafe_table(rng: np.random.Generator) -> Mesh:
    """A round table with two to four chairs, 0.8 m."""
    top = [(1e-3, 0.74), (0.35, 0.74), (0.35, 0.71), (1e-3, 0.71)]
    foot = [(0.03, 0.71), (0.03, 0.05), (0.24, 0.02), (0.24, 0.0)]
    count = int(rng.integers(2, 5))
    seat = Material(WOOD.texture, (0.6, 0.45, 0.3)) if rng.random() < 0.5 else ALUMINIUM
    start = rng.uniform(0, 6)
    chairs = [
        _chair(seat).placed(0.0, 0.0, 0.0, float(angle + rng.normal(0, 0.2)))
        for angle in start + np.arange(count) * 2 * np.pi / count
    ]
    return merge([revolve(top, ALUMINIUM, sides=14), revolve(foot, CAST_IRON, sides=8), *chairs])


@variants(6)
def parasol(rng: np.random.Generator) -> Mesh:
    """An open parasol, 3 m across and 2.6 m high."""
    cloth = Material("cloth", _CLOTHS[rng.integers(len(_CLOTHS))], translucent=0.35, infrared=0.6)
    angle = np.arange(9) * np.pi / 4 + np.pi / 8
    rim = np.column_stack([1.5 * np.cos(angle), 1.5 * np.sin(angle)])
    # Ribs hold the cloth up; between them it sags.
    between = 0.5 * (rim[:-1] + rim[1:]) * 0.97
    edge = np.concatenate([np.stack([rim[:-1], between], axis=1).reshape(-1, 2), rim[:1]])
    sag = np.where(np.arange(len(edge)) % 2 == 0, 0.0, -0.06)
    rings = [
        np.column_stack([edge * share, z + sag * share])
        for share, z in ((0.01, 2.6), (0.5, 2.42), (1, 2.12))
    ]
    valance = np.column_stack([edge, 1.95 + sag])
    foot = [(0.04, 0.1), (0.3, 0.06), (0.3, 0.0)]
    return merge(
        [
            pole(2.6, 0.025, ALUMINIUM),
            grid(np.array([*rings, valance]), None, cloth),
            revolve(foot, RAW_CONCRETE, sides=10),
        ]
    )


@variants(4)
def parasol_closed(rng: np.random.Generator) -> Mesh:
    """A folded parasol, 2.6 m."""
    cloth = Material("cloth", _CLOTHS[rng.integers(len(_CLOTHS))], infrared=0.6)
    folds = [(1e-3, 2.6), (0.06, 2.5), (0.12, 1.9), (0.1, 1.6), (0.17, 1.1), (0.03, 1.08)]
    foot = [(0.04, 0.1), (0.3, 0.06), (0.3, 0.0)]
    body = revolve(folds, cloth, sides=10)
    return merge([pole(2.6, 0.025, ALUMINIUM), body, revolve(foot, RAW_CONCRETE, sides=10)])


@variants(5)
def planter(rng: np.random.Generator) -> Mesh:
    """A tub with a bush or flowers, 0.9 to 1.5 m."""
    pots = (
        RAW_CONCRETE,
        Material(tint=(0.35, 0.14, 0.08), infrared=0.5),
        painted(0.05, 0.055, 0.06),
    )
    pot = pots[rng.integers(len(pots))]
    high = float(rng.uniform(0.4, 0.55))
    if rng.random() < 0.5:
        tub = [(0.36, high), (0.4, high), (0.38, high - 0.06), (0.28, 0.0)]
        vessel = revolve(tub, pot, sides=14)
    else:
        vessel = box(0.7, 0.7, high, pot)
    bush = _leaves(rng, (0.42, 0.42, float(rng.uniform(0.35, 0.6))), 170)
    return merge([vessel, _soil(0.33, high + 0.005), bush.placed(0, 0, high + 0.25)])


@variants(5)
def flower_box(rng: np.random.Generator) -> Mesh:
    """A long box of flowers, 1 m along y; for pavements and window sills."""
    pot = painted(0.3, 0.13, 0.07) if rng.random() < 0.5 else RAW_CONCRETE
    bush = _leaves(rng, (0.16, 0.52, 0.16), 150, flowers=0.5)
    return merge([box(0.24, 1.0, 0.22, pot), bush.placed(0.0, 0.0, 0.28)])


def _chair(material: Material) -> Mesh:
    """Its seat 0.6 m from the origin, looking at it from +x."""
    legs = copies(
        tube([(0, 0, 0), (0, 0, 0.45)], 0.014, ALUMINIUM, sides=4, capped=False),
        [(x, y, 0, 0) for x in (0.42, 0.8) for y in (-0.19, 0.19)],
    )
    posts = copies(
        tube([(0, 0, 0.45), (0.07, 0, 0.86)], 0.014, ALUMINIUM, sides=4, capped=False),
        [(0.8, y, 0, 0) for y in (-0.19, 0.19)],
    )
    back = box(0.02, 0.4, 0.2, material).placed(0.855, 0, 0.64)
    return merge([box(0.42, 0.42, 0.03, material).placed(0.61, 0, 0.44), back, legs, posts])


def _leaves(
    rng: np.random.Generator, radii: tuple[float, float, float], count: int, flowers: float = 0.15
) -> Mesh:
    """Small leaves and flowers round a dark core."""
    green = Material(tint=(0.06, 0.13, 0.03), translucent=0.35, infrared=0.7)
    bloom = Material(tint=_FLOWERS[rng.integers(len(_FLOWERS))], translucent=0.2, infrared=0.6)
    dark = Material(tint=(0.015, 0.03, 0.01), infrared=0.5)
    parts = [ellipsoid((0, 0, 0), 0.7 * np.array(radii), dark, rings=5)]
    for material, number in ((green, count - int(flowers * count)), (bloom, int(flowers * count))):
        ray = rng.standard_normal((number, 3))
        ray /= np.linalg.norm(ray, axis=1, keepdims=True)
        place = ray * np.array(radii) * rng.uniform(0.7, 1.0, (number, 1))
        size = 0.075 if material is green else 0.05
        first = np.cross(ray, rng.standard_normal((number, 3)))
        first *= size / np.linalg.norm(first, axis=1, keepdims=True)
        second = np.cross(ray, first) * 0.8 + 0.4 * size * rng.standard_normal((number, 1)) * ray
        corners = np.stack([place - first, place - second, place + first, place + second], axis=1)
        parts.append(facets(corners, material))
    return merge(parts)


def _soil(radius: float, height: float) -> Mesh:
    angle = np.arange(8) * np.pi / 4
    return polygon(
        np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.full(8, height)]), SOIL
    )
