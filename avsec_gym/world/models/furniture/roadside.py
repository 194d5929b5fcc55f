"""Small posts at the roadside: delineators, bollards, cones, and what guards a building site."""

from __future__ import annotations

import numpy as np

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.models.furniture.materials import (
    BLACK_PLASTIC,
    CAST_IRON,
    GALVANISED,
    RAW_CONCRETE,
    WHITE_PLASTIC,
    painted,
)
from avsec_gym.world.models.furniture.plate import board
from avsec_gym.world.models.furniture.poles import DEPTH, pole
from avsec_gym.world.models.furniture.variants import variants
from avsec_gym.world.shapes import box, grid, hard_edges, polygon, prism, revolve, tube

_RED_PAINT = painted(0.6, 0.02, 0.02)
_ORANGE = painted(0.85, 0.14, 0.03, infrared=0.7)
_REFLECTING = Material(tint=(0.85, 0.85, 0.83), infrared=1.0)
_SLANTED_BANDS = Material("banded/1", infrared=1.0)
_AMBER = Material(tint=(1.0, 0.5, 0.03), mirror=0.08, infrared=0.8, glow=0.25)


@variants(1)
def delineator(rng: np.random.Generator) -> Mesh:
    """A white post of 1 m with a black band and a reflector, its top cut slantwise."""
    plan = np.array([(-0.05, 0.06), (-0.05, -0.06), (0.07, 0.0)])
    body = prism(plan, 1.0, WHITE_PLASTIC, bottom=-DEPTH)
    face = Material("delineator", mirror=0.02, infrared=0.9)
    front = [(-0.051, 0.06, 0.0), (-0.051, -0.06, 0.0), (-0.051, -0.06, 1.0), (-0.051, 0.06, 1.08)]
    uv = [(0, 1.08), (0.12, 1.08), (0.12, 0.08), (0, 0)]
    lid = [(-0.051, 0.06, 1.08), (-0.051, -0.06, 1.0), (0.07, 0.0, 1.0)]
    gap = [(0.07, 0.0, 1.0), (-0.05, 0.06, 1.0), (-0.051, 0.06, 1.08)]
    return merge(
        [body, polygon(front, face, uv), polygon(lid, WHITE_PLASTIC), polygon(gap, WHITE_PLASTIC)]
    )


@variants(3)
def bollard_iron(rng: np.random.Generator) -> Mesh:
    """A cast-iron bollard with a knob, 0.9 to 1 m."""
    height = float(rng.uniform(0.9, 1.0))
    profile = [
        (1e-3, 1.0),
        (0.05, 0.985),
        (0.07, 0.94),
        (0.045, 0.89),
        (0.075, 0.86),
        (0.06, 0.8),
        (0.07, 0.14),
        (0.1, 0.1),
        (0.1, 0.0),
        (0.1, -DEPTH),
    ]
    return revolve(np.array(profile) * [1.0, height], CAST_IRON, sides=12)


@variants(2)
def bollard_steel(rng: np.random.Generator) -> Mesh:
    """A plain steel tube with a flat lid, 1 m."""
    tint = painted(0.1, 0.11, 0.11) if rng.random() < 0.5 else GALVANISED
    return pole(1.0, 0.04, tint, sides=10)


@variants(2)
def bollard_banded(rng: np.random.Generator) -> Mesh:
    """A post with red and white bands, 1 m: keeps cars off footpaths."""
    rows = [(0.0, 0.15), (0.15, 0.4), (0.4, 0.6), (0.6, 0.8), (0.8, 1.0)]
    paints = [WHITE_PLASTIC, WHITE_PLASTIC, _RED_PAINT, _REFLECTING, _RED_PAINT]
    bands = [
        tube(
            [(0, 0, low if low else -DEPTH), (0, 0, high)],
            0.042,
            paint,
            capped=high == 1.0,
            sides=8,
        )
        for (low, high), paint in zip(rows, paints, strict=True)
    ]
    return merge(bands)


@variants(2)
def bollard_stone(rng: np.random.Generator) -> Mesh:
    """A block of concrete, round or square, 0.5 to 0.8 m."""
    if rng.random() < 0.5:
        return hard_edges(box(0.4, 0.4, 0.5 + 0.2, RAW_CONCRETE).placed(0, 0, -0.2))
    profile = [(1e-3, 0.8), (0.13, 0.77), (0.17, 0.7), (0.2, -DEPTH)]
    return revolve(profile, RAW_CONCRETE, sides=14)


@variants(1)
def traffic_cone(rng: np.random.Generator) -> Mesh:
    """An orange cone with white bands, 0.75 m."""
    base = box(0.4, 0.4, 0.05, BLACK_PLASTIC)
    heights = [0.05, 0.25, 0.38, 0.47, 0.58, 0.75]
    paints = [_ORANGE, _REFLECTING, _ORANGE, _REFLECTING, _ORANGE]
    radius = np.interp(heights, [0.05, 0.75], [0.15, 0.03])
    bands = [
        tube([(0, 0, heights[i]), (0, 0, heights[i + 1])], radius[i : i + 2], paint, capped=i == 4)
        for i, paint in enumerate(paints)
    ]
    return merge([base, *bands])


@variants(2)
def site_barrier(rng: np.random.Generator) -> Mesh:
    """A red and white barrier of 2 m on two feet, with two amber lamps: building sites."""
    rail = Material("banded/0", infrared=1.0)
    parts = [board(2.0, 0.25, rail, rail).placed(0, 0, 0.92)]
    if rng.random() < 0.5:
        parts.append(board(2.0, 0.12, rail, rail).placed(0, 0, 0.25))
    for side in (-0.85, 0.85):
        parts += [
            box(0.7, 0.25, 0.1, BLACK_PLASTIC).placed(0, side),
            box(0.05, 0.05, 1.1, GALVANISED).placed(0.035, side, 0.02),
            _warning_lamp().placed(0.0, side, 1.07),
        ]
    return merge(parts)


@variants(1)
def warning_beacon(rng: np.random.Generator) -> Mesh:
    """An upright board with slanting bands on a foot, 1.2 m, with an amber lamp."""
    sign = board(0.25, 1.0, _SLANTED_BANDS, _SLANTED_BANDS).placed(0, 0, 0.65)
    foot = box(0.8, 0.4, 0.12, BLACK_PLASTIC)
    return merge(
        [
            foot,
            box(0.05, 0.05, 1.1, GALVANISED).placed(0.04, 0),
            sign,
            _warning_lamp().placed(0, 0, 1.16),
        ]
    )


def _warning_lamp() -> Mesh:
    lens = tube([(-0.04, 0, 0.17), (0.04, 0, 0.17)], 0.085, _AMBER, sides=10)
    return merge([box(0.07, 0.14, 0.1, BLACK_PLASTIC), lens])


@variants(3)
def site_fence(rng: np.random.Generator) -> Mesh:
    """A panel of 3.4 m by 2 m on concrete feet, its net as a tarpaulin: building sites."""
    tints = ((0.75, 0.75, 0.72), (0.12, 0.25, 0.5), (0.1, 0.35, 0.15))
    tarpaulin = Material("cloth", tints[rng.integers(3)], translucent=0.25, infrared=0.5)
    frame = [tube([(0, y, 0.1), (0, y, 2.05)], 0.022, GALVANISED, sides=6) for y in (-1.7, 1.7)]
    frame += [tube([(0, -1.7, z), (0, 1.7, z)], 0.018, GALVANISED, sides=6) for z in (0.2, 2.02)]
    y, z = np.meshgrid(np.linspace(1.68, -1.68, 12), np.linspace(1.98, 0.24, 5), indexing="ij")
    waves = 0.03 * np.sin(5.0 * y + 2.0 * z + rng.uniform(0, 6)) * np.sin(np.pi * (z - 0.24) / 1.74)
    sheet = grid(np.stack([waves, y, z], axis=-1), None, tarpaulin)
    feet = [box(0.7, 0.24, 0.15, RAW_CONCRETE).placed(0, y) for y in (-1.7, 1.7)]
    return merge([*frame, sheet, *feet])
