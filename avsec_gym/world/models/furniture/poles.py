"""Poles, and what stands as one: telephone and tram masts, flag poles."""

from __future__ import annotations

import numpy as np

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.models.furniture.materials import (
    GALVANISED,
    UPRIGHT_WOOD,
    WHITE_PLASTIC,
    WOOD,
)
from avsec_gym.world.models.furniture.variants import variants
from avsec_gym.world.shapes import box, grid, tube

DEPTH = 0.3
"""How far poles reach into the ground, so that none floats on a slope; metres."""


def pole(
    height: float,
    radius: float,
    material: Material = GALVANISED,
    *,
    top_radius: float | None = None,
    sides: int = 8,
) -> Mesh:
    """An upright pole on the origin, its foot in the ground."""
    tip = radius if top_radius is None else top_radius
    return tube([(0, 0, -DEPTH), (0, 0, height)], [radius, tip], material, sides=sides)


@variants(3)
def telephone_mast(rng: np.random.Generator) -> Mesh:
    """A wooden mast with a crossbar along y and insulators, 7 to 8 m; wires run along x."""
    height = float(rng.uniform(7.0, 8.0))
    bar = box(0.09, 1.5, 0.11, WOOD).placed(0.13, 0.0, height - 0.5)
    cups = [
        tube([(0.13, y, height - 0.4), (0.13, y, height - 0.22)], 0.035, WHITE_PLASTIC, sides=6)
        for y in (-0.65, -0.3, 0.3, 0.65)
    ]
    return merge([pole(height, 0.14, UPRIGHT_WOOD, top_radius=0.09), bar, *cups])


@variants(4)
def flag_pole(rng: np.random.Generator) -> Mesh:
    """A white pole, 7 m, with a long flag on a short arm to the left."""
    picture = Material(f"flag/{rng.integers(4)}", translucent=0.3, infrared=0.5)
    swing = rng.uniform(0, 6)
    u, v = np.meshgrid(np.linspace(0, 1.2, 7), np.linspace(0, 3.0, 7), indexing="ij")
    # Fixed above and at the pole; the free corner swings most.
    x = 0.16 * np.sin(4.0 * u + 1.2 * v + swing) * (u / 1.2) * (0.3 + v / 3.0)
    cloth = grid(np.stack([x, 1.27 - u, 6.8 - v], axis=-1), np.stack([u, v], axis=-1), picture)
    arm = tube([(0, 0, 6.82), (0, 1.3, 6.82)], 0.015, WHITE_PLASTIC, sides=5)
    return merge([pole(7.0, 0.06, WHITE_PLASTIC, top_radius=0.035), arm, cloth])
