"""Colours and materials of German houses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avsec_gym.world.material import Material
from avsec_gym.world.models.buildings.roofs import RoofMaterials

Colour = tuple[int, int, int]
"""Red, green, blue as a screen shows them, 0 to 255."""

STUCCO: tuple[Colour, ...] = (
    (236, 230, 214),
    (240, 236, 228),
    (226, 214, 186),
    (222, 198, 152),
    (230, 204, 176),
    (214, 176, 150),
    (206, 206, 200),
    (186, 184, 178),
    (204, 210, 190),
    (200, 206, 212),
    (226, 212, 168),
    (196, 160, 120),
)
"""Cream, white, sand (these most often), ochre, apricot, salmon, greys, pale green and blue,
yellow, brown."""

WHITE = Material("plain", (0.78, 0.78, 0.76))
WHITE_FRAME = Material("plain", (0.72, 0.72, 0.70), mirror=0.02, infrared=0.6)
DARK_FRAME = Material("plain", (0.045, 0.04, 0.035), mirror=0.03, infrared=0.2)
BROWN_FRAME = Material("plain", (0.10, 0.05, 0.028), mirror=0.02, infrared=0.35)
ALUMINIUM = Material("plain", (0.42, 0.43, 0.44), mirror=0.12, infrared=0.5)
ZINC = Material("sheet_metal", (0.42, 0.44, 0.46), mirror=0.04, infrared=0.4)
COPPER = Material("sheet_metal", (0.17, 0.12, 0.09), infrared=0.3)
STONE_SILL = Material("concrete/0", (0.62, 0.60, 0.56))
CONCRETE = Material("concrete/1", (0.80, 0.79, 0.76))
GRAVEL = Material("stucco/2", (0.32, 0.31, 0.29))
IRON = Material("plain", (0.03, 0.03, 0.032), mirror=0.03, infrared=0.15)


def linear(colour: Colour) -> tuple[float, float, float]:
    """A screen's colour as shares of light."""
    red, green, blue = (round((channel / 255.0) ** 2.2, 4) for channel in colour)
    return red, green, blue


def pick(rng: np.random.Generator, *choices: Material) -> Material:
    """One of them, each as likely."""
    return choices[int(rng.integers(len(choices)))]


def stucco(rng: np.random.Generator) -> Material:
    """A painted wall."""
    colour = STUCCO[int(rng.integers(3 if rng.random() < 0.3 else len(STUCCO)))]
    return darker(
        Material(f"stucco/{int(rng.integers(4))}", linear(colour)), rng.uniform(0.75, 1.0)
    )


def splashed(render: Material) -> Material:
    """The lowest metre of a wall of render."""
    return replace(render, texture=render.texture.replace("stucco", "stucco_foot"))


def darker(material: Material, share: float) -> Material:
    """The same paint, darker."""
    red, green, blue = (share * channel for channel in material.tint)
    return Material(material.texture, (red, green, blue), infrared=material.infrared)


def brick(rng: np.random.Generator) -> Material:
    """Clinker or common brick."""
    return Material(f"brick/{int(rng.integers(5))}")


def sandstone(rng: np.random.Generator) -> Material:
    """Ashlar: red, yellow or grey."""
    return Material(f"sandstone/{int(rng.integers(4))}")


def tiled_roof(rng: np.random.Generator, *, slate: float = 0.0) -> RoofMaterials:
    """Clay tiles, mostly red; slate with the chance `slate`."""
    if rng.random() < slate:
        tiles = Material("slate", infrared=0.15)
    else:
        tiles = Material(f"roof_tile/{int(rng.choice(4, p=[0.4, 0.25, 0.22, 0.13]))}")
    board = pick(rng, WHITE, Material("timber/0", (0.35, 0.22, 0.14)), BROWN_FRAME)
    return RoofMaterials(tiles, board, pick(rng, ZINC, COPPER, BROWN_FRAME))


def door_leaf(rng: np.random.Generator) -> Material:
    """Wood, or white plastic with glass."""
    return Material(f"door/{int(rng.integers(4))}", mirror=0.02, infrared=0.35)


def roller_shutter(rng: np.random.Generator) -> Material:
    """White, grey, beige or brown slats."""
    tints = ((0.75, 0.75, 0.73), (0.5, 0.5, 0.5), (0.6, 0.52, 0.4), (0.25, 0.16, 0.1))
    return Material("shutter", tints[int(rng.integers(len(tints)))], infrared=0.5)


def folding_shutter(rng: np.random.Generator) -> Material:
    """Painted boards: brown, green, grey, blue."""
    colours = ((92, 58, 36), (52, 78, 54), (120, 116, 108), (74, 92, 112))
    return Material("shutter", linear(colours[int(rng.integers(len(colours)))]), infrared=0.4)
