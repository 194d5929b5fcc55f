"""Textures of roofs and metal cladding; v runs down the slope."""

from __future__ import annotations

import numpy as np

from avsec_gym.world.textures.noise import coloured, fractal_noise, picture, white_noise
from avsec_gym.world.textures.texture import Picture

_CLAY = ((146, 78, 56), (120, 70, 54), (98, 68, 54), (66, 66, 68))


def roof_tile(variant: int, rng: np.random.Generator) -> Picture:
    """Pantiles of 0.3 m x 0.34 m: new red, weathered red, brown, anthracite; 3.6 m x 4.08 m."""
    size, count = 512, 12
    at = (np.arange(size) + 0.5) * count / size
    across, down = at % 1.0, at % 1.0
    tone = rng.normal(0.0, (0.035, 0.075, 0.06, 0.035)[variant], (count, count)).astype(np.float32)
    index = at.astype(np.intp)
    wave = 0.16 * np.sin(2 * np.pi * across) - 0.28 * (across < 0.09)
    course = 0.1 * (down - 0.5) - 0.42 * (down < 0.1) + 0.1 * (down > 0.9)
    clouds = fractal_noise(rng, size, size, cells=5, octaves=6, persistence=0.6)
    noise = tone[index[:, None], index] + wave[None] + course[:, None]
    noise += 0.04 * clouds + 0.03 * white_noise(rng, size, size, 0.7)
    value = coloured(_CLAY[variant], noise, 1.0)
    if variant == 1:
        moss = np.clip(0.5 * clouds - 0.35, 0, 0.6)[..., None]
        value = value * (1 - moss) + np.array([84, 80, 58]) * moss
    return picture(value)


def slate(_: int, rng: np.random.Generator) -> Picture:
    """Overlapping slates of 0.25 m x 0.2 m, every second course shifted; 3 m x 3.2 m."""
    size, rows, columns = 512, 16, 12
    y = (np.arange(size) + 0.5) * rows / size
    row = y.astype(np.intp)
    x = (np.arange(size) + 0.5)[None] * columns / size + 0.5 * (row % 2)[:, None]
    column = x.astype(np.intp) % columns
    tone = rng.normal(0.0, 0.13, (rows, columns)).astype(np.float32)
    noise = tone[row[:, None], column] + 0.08 * white_noise(rng, size, size, 0.8)
    noise -= 0.4 * ((y % 1.0) < 0.12)[:, None] + 0.3 * (np.abs(x % 1.0 - 0.5) > 0.47)
    return picture(coloured((82, 84, 90), noise, 1.0))


def sheet_metal(_: int, rng: np.random.Generator) -> Picture:
    """Sheets with standing seams 0.5 m apart, near white; 2 m x 4 m."""
    height, width = 512, 256
    x = np.arange(width) % 64
    seam = np.where(x < 2, 0.08, 0.0) - np.where((x >= 2) & (x < 4), 0.35, 0.0)
    stain = fractal_noise(rng, height, width, cells=6, octaves=6, persistence=0.6)
    return picture(coloured((214, 216, 218), seam[None] + 0.05 * stain, 1.0))


def cladding(_: int, rng: np.random.Generator) -> Picture:
    """Trapezoidal sheets, upright ribs every 0.25 m, near white; 2 m x 4 m."""
    height, width = 512, 256
    phase = np.arange(width) % 32
    rib = np.select([phase < 3, phase < 14, phase < 17], [-0.22, 0.02, 0.06], -0.07)
    stain = fractal_noise(rng, height, width, cells=4, octaves=6, persistence=0.55)
    seam = np.where(np.arange(height) < 2, -0.3, 0.0)[:, None]
    return picture(coloured((222, 223, 224), rib[None] + seam + 0.03 * stain, 1.0))
