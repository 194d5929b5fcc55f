"""Traffic lights, facing oncoming traffic (-x)."""

from __future__ import annotations

import functools

import numpy as np

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh, merge
from avsec_gym.world.models.furniture.materials import BLACK_PLASTIC, GALVANISED, painted
from avsec_gym.world.models.furniture.poles import pole
from avsec_gym.world.models.furniture.variants import prescribed
from avsec_gym.world.shapes import box, grid, polygon, tube

LIT = {"red": (True, False, False), "amber": (False, True, False), "green": (False, False, True)}
"""Which of the lamps are on, from above."""

_COLOURS = ((1.0, 0.02, 0.015), (1.0, 0.3, 0.01), (0.03, 0.75, 0.4))
_HOUSING = painted(0.33, 0.38, 0.35)
_BUTTON = painted(0.85, 0.45, 0.01)
_BLUE = painted(0.02, 0.08, 0.3)


@prescribed
def traffic_light(rng: np.random.Generator) -> Mesh:
    """On a pole of 3.5 m beside the road, in one of its states."""
    return standing_light(str(rng.choice(list(LIT))))


@functools.cache
def standing_light(state: str) -> Mesh:
    """A light on a pole, with a push button for walkers.

    Raises:
        KeyError: The state is not in `LIT`.
    """
    return merge(
        [*_post(), _head(state, 0.1).placed(-0.04, -0.27, 2.2), _bracket(2.4), _bracket(2.9)]
    )


def _post() -> list[Mesh]:
    """A pole of 3.6 m that is thicker up to the height of its little door."""
    radius = 0.06
    button = box(0.1, 0.12, 0.22, _BUTTON).placed(-radius - 0.05, 0.0, 0.95)
    plaque = box(0.1, 0.09, 0.18, _BLUE).placed(0.0, radius + 0.05, 1.25)
    return [pole(1.5, radius + 0.02), pole(3.6, radius), button, plaque]


def _bracket(height: float) -> Mesh:
    return tube([(0, 0.02, height), (0, -0.2, height)], 0.018, GALVANISED, sides=5, capped=False)


@functools.cache
def _head(state: str, radius: float) -> Mesh:
    """Three lamps one above the other; the housing's bottom at the origin, lenses at -x."""
    pitch = 2.8 * radius
    depth, width = 1.5 * radius, 2.8 * radius
    parts = [
        box(depth, width, 3 * pitch, _HOUSING),
        box(0.02, 0.96 * width, 2.96 * pitch, BLACK_PLASTIC).placed(
            -0.5 * depth - 0.01, 0, 0.02 * pitch
        ),
    ]
    front = -0.5 * depth - 0.022
    angle = np.arange(12) * np.pi / 6
    for lamp, (colour, lit) in enumerate(zip(_COLOURS, LIT[state], strict=True)):
        middle = (2.5 - lamp) * pitch
        light = Material(
            tint=colour if lit else tuple(0.06 * c + 0.01 for c in colour),  # type: ignore[arg-type]
            mirror=0.06,
            infrared=0.3,
            glow=0.9 if lit else 0.0,
        )
        disc = [(front, -radius * np.sin(a), middle - radius * np.cos(a)) for a in angle]
        parts += [polygon(disc, light), _visor(radius, front, middle)]
    return merge(parts)


def _visor(radius: float, front: float, middle: float) -> Mesh:
    """A hood over a lens, longer above than at its sides."""
    angle = np.linspace(-0.3, np.pi + 0.3, 8)
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1) * radius * 1.12
    out = front - radius * (0.7 + 1.0 * np.clip(np.sin(angle), 0, 1))
    ring[:, 1] += middle
    inner = np.column_stack([np.full(len(angle), front), ring])
    outer = np.column_stack([out, ring])
    return grid(np.stack([inner, outer]), None, BLACK_PLASTIC)
