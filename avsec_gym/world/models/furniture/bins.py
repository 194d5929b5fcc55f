"""Dustbins, litter bins and containers."""

from __future__ import annotations

import numpy as np

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.models.furniture.materials import BLACK_PLASTIC, painted
from avsec_gym.world.models.furniture.poles import pole
from avsec_gym.world.models.furniture.variants import variants
from avsec_gym.world.shapes import grid, hard_edges, revolve, tube

_LIDS = (
    (0.02, 0.02, 0.022),
    (0.015, 0.09, 0.04),
    (0.02, 0.08, 0.3),
    (0.75, 0.5, 0.02),
    (0.2, 0.1, 0.05),
)
"""Black, green, blue (paper), yellow (wrappings), brown (garden)."""


@variants(8)
def wheelie_bin(rng: np.random.Generator) -> Mesh:
    """A dustbin on two wheels, 1.05 m; its wheels and handle are at the back (+x)."""
    return _wheelie_bin(rng)


def _wheelie_bin(rng: np.random.Generator) -> Mesh:
    lid = painted(*_LIDS[rng.integers(len(_LIDS))], infrared=0.3)
    body = painted(0.03, 0.032, 0.034, infrared=0.15)
    if rng.random() < 0.4:
        body = lid
    wide = float(rng.choice([0.48, 0.58]))
    return merge(
        [
            _tapered((0.44, wide - 0.12), (0.54, wide), 0.04, 0.95, body).placed(-0.02, 0),
            _tapered((0.63, wide + 0.05), (0.56, wide - 0.02), 0.93, 1.03, lid).placed(0.0, 0),
            tube([(0.31, -0.2, 0.96), (0.31, 0.2, 0.96)], 0.02, body, sides=4),
            *[
                tube([(0.2, y - 0.03, 0.1), (0.2, y + 0.03, 0.1)], 0.1, BLACK_PLASTIC, sides=7)
                for y in (-0.22, 0.22)
            ],
        ]
    )


@variants(2)
def bin_row(rng: np.random.Generator) -> Mesh:
    """Two or three dustbins side by side along y, as on collection day."""
    count = int(rng.integers(2, 4))
    return merge(
        [
            _wheelie_bin(rng).placed(
                float(rng.uniform(-0.1, 0.1)),
                0.72 * i - 0.36 * (count - 1),
                0.0,
                float(rng.normal(0, 0.15)),
            )
            for i in range(count)
        ]
    )


@variants(3)
def litter_bin(rng: np.random.Generator) -> Mesh:
    """A bin on a pole, 1.1 m, with a round mouth to the front."""
    tint = ((0.75, 0.25, 0.02), (0.08, 0.16, 0.1), (0.18, 0.19, 0.2))[rng.integers(3)]
    paint = painted(*tint, worn=int(rng.integers(3)))
    profile = [(1e-3, 1.0), (0.1, 0.98), (0.19, 0.9), (0.2, 0.84), (0.19, 0.42), (1e-3, 0.4)]
    drum = revolve(profile, paint, sides=14)
    mouth = tube([(-0.18, 0, 0.8), (-0.205, 0, 0.8)], 0.09, BLACK_PLASTIC)
    return merge([pole(1.1, 0.035), *[part.placed(-0.22, 0) for part in (drum, mouth)]])


def _tapered(
    low: tuple[float, float],
    high: tuple[float, float],
    bottom: float,
    top: float,
    material: Material,
) -> Mesh:
    """A block whose lower and upper rectangles (x, y) differ."""
    corner = np.array([(1, -1), (1, 1), (-1, 1), (-1, -1), (1, -1)])
    rings = [
        np.column_stack([0.5 * corner * size, np.full(5, height)])
        for size, height in (
            ((1e-3, 1e-3), top),
            (high, top),
            (low, bottom),
            ((1e-3, 1e-3), bottom),
        )
    ]
    return hard_edges(grid(np.array(rings), None, material))
