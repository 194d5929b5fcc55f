"""Shop windows with their frames, stall risers, awnings and signs."""

from __future__ import annotations

import numpy as np

from avsec_gym.world.material import Material
from avsec_gym.world.models.buildings import palette
from avsec_gym.world.models.buildings.attachments import awning, sign
from avsec_gym.world.models.buildings.panels import Floats, Panels, upright
from avsec_gym.world.models.buildings.windows import bars, doors, reveals

SHOPS, SIGNS = 10, 13
"""Variants of the texture ``shop_sign``: the first ones for shops, the others for workshops."""

_DISPLAYS = 5


def shop_front(
    width: float, height: float, pier: Material, rng: np.random.Generator
) -> tuple[list[Panels], Floats]:
    """A ground floor of glass between piers.

    Args:
        width: Width of the house, metres.
        height: Height of the ground floor, metres.
        pier: Material of the wall between the windows.
        rng: Generator that draws the shops.

    Returns:
        Panels for a wall along x that faces -y, and the openings that it must have, shape (n, 4).
    """
    bays = max(1, round(width / 4.2))
    pitch = width / bays
    high = height - 1.0
    frame = palette.pick(rng, palette.DARK_FRAME, palette.ALUMINIUM, palette.BROWN_FRAME)
    entrance = int(rng.integers(bays))
    x0 = -0.5 * width + pitch * np.arange(bays) + 0.25
    x1 = x0 + pitch - 0.5
    glass = np.stack([x0, x1, np.full(bays, 0.35), np.full(bays, high)], axis=1)
    glass[entrance, 1] -= 1.35
    door = np.array([[glass[entrance, 1] + 0.15, x1[entrance], 0.05, high]])
    parts = [reveals(glass, 0.0, 0.25, frame)]
    for bay, number in zip(glass, np.resize(rng.permutation(_DISPLAYS), bays), strict=True):
        display = Material(f"shop_window/{number}", mirror=0.08, infrared=0.06)
        parts.append(upright(display, *bay, y=0.25, once=True))
        parts.append(bars(frame, bay, 1 + int(bay[1] - bay[0] > 2.4), 1, 0.08, 0.2))
    parts += doors(door, Material("door/5", mirror=0.06, infrared=0.1), frame, frame, border=0.0)
    parts += _above(width, bays, height, rng)
    return parts, np.concatenate([glass, door])


def _above(width: float, bays: int, height: float, rng: np.random.Generator) -> list[Panels]:
    """Signs over all bays or one long one; awnings over some."""
    parts: list[Panels] = []
    pitch, low, names = width / bays, height - 0.9, rng.permutation(SHOPS)
    if rng.random() < 0.5 or bays == 1:
        half = 0.5 * min(6.0, float(rng.uniform(0.5, 0.85)) * width)
        parts += sign(-half, half, low, low + 0.6, int(names[0]))
    else:
        for bay in range(bays):
            middle = -0.5 * width + (bay + 0.5) * pitch
            half = 0.5 * pitch * float(rng.uniform(0.55, 0.85))
            parts += sign(middle - half, middle + half, low, low + 0.55, int(names[bay % SHOPS]))
    if rng.random() < 0.55:
        tints = ((0.75, 0.73, 0.68), (0.45, 0.04, 0.04), (0.05, 0.18, 0.09), (0.7, 0.55, 0.25))
        stripes = int(rng.integers(2))
        tint = tints[int(rng.integers(len(tints)))]
        cloth = Material(f"awning/{stripes}", tint, translucent=0.15, infrared=0.6)
        depth = float(rng.uniform(1.0, 1.5))
        parts += awning(-0.5 * width + 0.15, 0.5 * width - 0.15, height - 1.0, depth, cloth)
    return parts
