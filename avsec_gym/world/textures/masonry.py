"""Textures of walls: stucco, brick, ashlar, rubble, concrete, tiles, boards, glass blocks."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from avsec_gym.world.textures.noise import coloured, fractal_noise, picture, white_noise
from avsec_gym.world.textures.texture import Picture

Floats = NDArray[np.float32]

_RENDER = (233, 232, 229)
_GRAIN_LUMPS_STAINS = (
    (0.012, 0.0, 0.012),
    (0.03, 0.03, 0.015),
    (0.035, 0.05, 0.02),
    (0.02, 0.02, 0.03),
)
_BRICKS = ((150, 74, 54), (120, 58, 46), (178, 140, 96), (112, 76, 58), (168, 96, 62))
_MORTARS = ((168, 160, 148), (130, 124, 116), (176, 168, 152), (140, 134, 126), (188, 180, 168))
_STONES = ((172, 132, 110), (198, 176, 138), (158, 152, 142), (188, 170, 148))
_TILES = ((176, 180, 182), (26, 30, 36))


def stucco(variant: int, rng: np.random.Generator) -> Picture:
    """Near-white render: fine, rough, scratched and old; faint stains, no pattern to recognise."""
    return picture(coloured(_RENDER, _roughness(variant, rng, 512, 512), 1.0))


def stucco_foot(variant: int, rng: np.random.Generator) -> Picture:
    """The lowest metre of such a wall: splashed and mouldy below, clean at the top."""
    height, width = 102, 512
    clouds = fractal_noise(rng, height, width, cells=10, octaves=6, persistence=0.75)
    up = np.linspace(1.0, 0.0, height, dtype=np.float32)[:, None]
    dirt = np.clip(0.5 - 1.3 * up + 0.24 * clouds, 0, 1) * np.clip(4.0 - 4.0 * up, 0, 1)
    share = 0.6 * dirt[..., None]
    grime = coloured((128, 120, 104), 0.06 * clouds, 1.0)
    clean = coloured(_RENDER, _roughness(variant, rng, height, width), 1.0)
    return picture(clean * (1 - share) + grime * share)


def brick(variant: int, rng: np.random.Generator) -> Picture:
    """Running bond, 0.25 m x 0.071 m with its joints; 4 m x 4 m."""
    size, rows, columns = 512, 56, 16
    tone = rng.normal(0.0, 0.08, (rows, columns)).astype(np.float32)
    tone -= 0.25 * (rng.random((rows, columns)) < 0.05)
    shift = 0.5 * (np.arange(rows) % 2)
    cell, edge = _bond(size, size, rows, columns, shift, (0.7, 0.7))
    clouds = fractal_noise(rng, size, size, cells=5, octaves=6, persistence=0.6)
    noise = tone[cell] + 0.04 * clouds + 0.05 * white_noise(rng, size, size)
    face = coloured(_BRICKS[variant], noise, 1.0)
    mortar = coloured(_MORTARS[variant], 0.04 * clouds, 1.0)
    return picture(np.where(edge[..., None], mortar, face))


def sandstone(variant: int, rng: np.random.Generator) -> Picture:
    """Ashlar in courses of 0.4 m; 4.8 m x 4.8 m."""
    size, rows, columns = 512, 12, 7
    tone = rng.normal(0.0, 0.055, (rows, columns)).astype(np.float32)
    cell, edge = _bond(size, size, rows, columns, rng.random(rows), (1.0, 1.0))
    clouds = fractal_noise(rng, size, size, cells=7, octaves=7, persistence=0.65)
    noise = tone[cell] + 0.05 * clouds + 0.03 * white_noise(rng, size, size, 0.7)
    noise += 0.03 * _runs(rng, size, size)
    face = coloured(_STONES[variant], noise, 1.0)
    joint = coloured(_STONES[variant], 0.1 * clouds - 0.32, 1.0)
    light = np.roll(edge, 1, axis=0) & ~edge
    return picture(np.where(edge[..., None], joint, face * (1.0 + 0.1 * light[..., None])))


def rubble(_: int, rng: np.random.Generator) -> Picture:
    """Split stone of garden walls, rough and grey, in low courses; 2 m x 2 m."""
    size, rows, columns = 512, 14, 6
    tone = rng.normal(0.0, 0.16, (rows, columns)).astype(np.float32)
    cell, edge = _bond(size, size, rows, columns, rng.random(rows), (2.5, 2.0))
    relief = fractal_noise(rng, size, size, cells=24, octaves=5, persistence=0.7)
    lit = relief - np.roll(relief, 2, axis=0)
    noise = tone[cell] + 0.09 * relief + 0.22 * lit + 0.05 * white_noise(rng, size, size)
    face = coloured((150, 143, 130), noise, 1.0)
    return picture(np.where(edge[..., None], 0.5 * face, face))


def concrete(variant: int, rng: np.random.Generator) -> Picture:
    """Cast in place, precast panels with joints, or washed; 4.8 m x 4.8 m."""
    size = 512
    stain = 0.035 * fractal_noise(rng, size, size, cells=6, octaves=6, persistence=0.6)
    noise = stain + 0.04 * _runs(rng, size, size) + 0.025 * white_noise(rng, size, size, 0.6)
    value = coloured((186, 183, 176), noise, 1.0)
    if variant == 2:
        value = coloured((176, 170, 158), stain + 0.11 * white_noise(rng, size, size, 0.8), 1.0)
    if variant > 0:
        _, joint = _bond(size, size, 4, 2, np.zeros(4), (0.8, 0.8))
        value *= np.where(joint, 0.6, 1.0)[..., None].astype(np.float32)
    return picture(value)


def wall_tile(variant: int, rng: np.random.Generator) -> Picture:
    """Glazed tiles of 0.21 m, each burnt a little differently: pale, black; 4.2 m x 4.2 m."""
    size, count = 512, 20
    spread = (0.09, 0.1)[variant]
    tone = np.clip(rng.normal(0.0, spread, (count, count)), -0.5, 0.55).astype(np.float32)
    cell, edge = _bond(size, size, count, count, np.zeros(count), (0.6, 0.6))
    clouds = fractal_noise(rng, size, size, cells=30, octaves=4, persistence=0.6)
    noise = tone[cell] + 0.05 * clouds
    face = coloured(_TILES[variant], noise, 1.0)
    joint = 0.5 * face + 0.5 * np.array(((142, 145, 146), (120, 66, 40))[variant])
    return picture(np.where(edge[..., None], joint, face))


def timber(variant: int, rng: np.random.Generator) -> Picture:
    """Upright boards of 0.125 m: brown stained, or weathered grey; 2 m x 4 m."""
    height, width, count = 512, 256, 16
    tone = rng.normal(0.0, 0.1, count).astype(np.float32)
    board = np.arange(width) * count // width
    gap = np.arange(width) % (width // count) == 0
    fibres = fractal_noise(rng, 32, width, cells=64, octaves=3)
    grain = np.asarray(cv2.resize(fibres, (width, height), interpolation=cv2.INTER_CUBIC))
    noise = tone[board][None] + 0.1 * grain + 0.03 * white_noise(rng, height, width)
    value = coloured(((112, 76, 46), (142, 128, 110))[variant], noise, 1.0)
    return picture(np.where(gap[None, :, None], 0.4 * value, value))


def glass_blocks(_: int, rng: np.random.Generator) -> Picture:
    """Translucent blocks of 0.2 m in the wall of a staircase; 1 m x 1 m."""
    size, count = 128, 5
    tone = rng.normal(0.0, 0.12, (count, count)).astype(np.float32)
    cell, edge = _bond(size, size, count, count, np.zeros(count), (1.2, 1.2))
    shade = tone[cell] + 0.08 * white_noise(rng, size, size, 2.0)
    return picture(np.where(edge[..., None], 168.0, coloured((96, 112, 116), shade, 1.0)))


def _roughness(variant: int, rng: np.random.Generator, height: int, width: int) -> Floats:
    """Grain, lumps and faint stains of render."""
    grain, bump, stain = _GRAIN_LUMPS_STAINS[variant]
    lumps = white_noise(rng, height, width, 1.6)
    noise = grain * white_noise(rng, height, width, 0.6)
    noise += bump * (lumps - np.roll(lumps, 1, axis=0))
    noise += stain * fractal_noise(rng, height, width, cells=6, octaves=4, persistence=0.6)
    return noise + 0.6 * stain * _runs(rng, height, width)


def _bond(
    height: int,
    width: int,
    rows: int,
    columns: int,
    shift: NDArray[np.floating],
    joint: tuple[float, float],
) -> tuple[tuple[NDArray[np.intp], NDArray[np.intp]], NDArray[np.bool_]]:
    """Which brick a pixel shows (row, column), and whether it is a joint.

    Args:
        height: Height of the picture, pixels.
        width: Width of the picture, pixels.
        rows: Number of rows of bricks.
        columns: Number of columns of bricks.
        shift: Shift of each row, in bricks, shape (rows,).
        joint: Half-widths of the joints, pixels: upright ones, level ones.
    """
    y = (np.arange(height) + 0.5) * rows / height
    row = np.floor(y).astype(np.intp)
    x = (np.arange(width) + 0.5)[None, :] * columns / width + shift[row][:, None]
    column = np.floor(x).astype(np.intp) % columns
    across, up = x % 1.0, (y % 1.0)[:, None]
    near_x = np.minimum(across, 1 - across) * width / columns < joint[0]
    near_y = np.minimum(up, 1 - up) * height / rows < joint[1]
    return (np.broadcast_to(row[:, None], column.shape), column), near_x | near_y


def _runs(rng: np.random.Generator, height: int, width: int) -> Floats:
    """Streaks that rain left on the wall: noise stretched downwards."""
    step = 64
    low = white_noise(rng, height // step, width, 1.2)
    tall = cv2.resize(np.concatenate([low, low[:1]]), (width, height + step))
    return np.asarray(tall[step // 2 : step // 2 + height], np.float32)
