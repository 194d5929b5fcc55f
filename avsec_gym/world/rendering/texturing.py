"""Kernels that read textures: bilinear, coarser afar, stretched at grazing angles."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.kernels import kernel
from avsec_gym.world.mesh import Float32s
from avsec_gym.world.textures.library import TextureArrays

_LINEAR = ((np.arange(256) / 255.0) ** 2.2).astype(np.float32)
_MOST_TAPS = 6
_ONE, _HALF = np.float32(1.0), np.float32(0.5)


class OverlayArrays(NamedTuple):
    """A scene's overlay with its levels of detail, for kernels."""

    texels: NDArray[np.uint8]
    """Red, green, blue (light times alpha, encoded like sRGB), alpha; all levels, shape (N, 4)."""
    first: NDArray[np.int64]
    """Where a level's pixels begin, shape (L,)."""
    shape: NDArray[np.int32]
    """Height and width of a level, shape (L, 2)."""
    scale: Float32s
    """Pixels of the finest level per metre, shape (2,)."""
    begin: Float32s
    """Overlay coordinate of the picture's left edge, metres, shape (1,)."""


@kernel(inline="always", error_model="numpy")
def texel_colour(textures, index, level, s, t):
    """Bilinear colour in linear light at (s, t), in repeats of the texture."""
    height = textures.shape[index, level, 0]
    width = textures.shape[index, level, 1]
    x = (s - np.floor(s)) * np.float32(width) - _HALF
    y = (t - np.floor(t)) * np.float32(height) - _HALF
    column, row = np.int32(np.floor(x)), np.int32(np.floor(y))
    fx, fy = x - np.float32(column), y - np.float32(row)
    # Cheaper than remainders: x and y are at most half a texel outside.
    left = column if column >= 0 else width - 1
    right = column + 1 if column + 1 < width else 0
    upper = row if row >= 0 else height - 1
    lower = row + 1 if row + 1 < height else 0
    first = textures.first[index, level]
    upper, lower = first + upper * width, first + lower * width
    a, b = (_ONE - fx) * (_ONE - fy), fx * (_ONE - fy)
    c, d = (_ONE - fx) * fy, fx * fy
    texels = textures.texels
    red = (
        a * _LINEAR[texels[upper + left, 0]]
        + b * _LINEAR[texels[upper + right, 0]]
        + c * _LINEAR[texels[lower + left, 0]]
        + d * _LINEAR[texels[lower + right, 0]]
    )
    green = (
        a * _LINEAR[texels[upper + left, 1]]
        + b * _LINEAR[texels[upper + right, 1]]
        + c * _LINEAR[texels[lower + left, 1]]
        + d * _LINEAR[texels[lower + right, 1]]
    )
    blue = (
        a * _LINEAR[texels[upper + left, 2]]
        + b * _LINEAR[texels[upper + right, 2]]
        + c * _LINEAR[texels[lower + left, 2]]
        + d * _LINEAR[texels[lower + right, 2]]
    )
    return red, green, blue


@kernel(error_model="numpy")
def filtered_colour(textures, index, u, v, short_u, short_v, long_u, long_v):
    """Mean colour of a texture under a pixel's footprint.

    The level of detail fits the footprint's shorter axis; taps along the longer one cover the rest.
    Invariant: there are 1 to `_MOST_TAPS` of them, and the level never leaves the texture's.

    Args:
        textures: The textures, `TextureArrays`.
        index: Index of the texture.
        u: Place on the texture, metres to the right.
        v: Place on the texture, metres down.
        short_u: Shorter axis of the footprint, metres to the right.
        short_v: Shorter axis of the footprint, metres down.
        long_u: Longer axis, along which the view is stretched, metres to the right.
        long_v: Longer axis, metres down.
    """
    # Axes in texels of the finest level; the shorter one is bounded by the number of taps.
    width, height = textures.size[index, 0], textures.size[index, 1]
    across = np.float32(textures.shape[index, 0, 1]) / width
    down = np.float32(textures.shape[index, 0, 0]) / height
    short = np.sqrt((short_u * across) ** 2 + (short_v * down) ** 2)
    long = np.sqrt((long_u * across) ** 2 + (long_v * down) ** 2)
    if short > long:
        short, long = long, short
        long_u, long_v = short_u, short_v
    short = max(short, long / np.float32(_MOST_TAPS), np.float32(1e-6))
    last = textures.levels[index] - 1
    level = min(max(np.log2(short), np.float32(0.0)), np.float32(last))
    taps = min(max(np.int32(long / max(short, _ONE) + _HALF), 1), _MOST_TAPS)
    # Many taps hide the step between levels; one needs both neighbours.
    fine = np.int32(level + _HALF) if taps > 2 else np.int32(level)
    share = np.float32(0.0) if taps > 2 else level - np.float32(fine)
    red, green, blue = np.float32(0.0), np.float32(0.0), np.float32(0.0)
    for tap in range(taps):
        step = (np.float32(tap) + _HALF) / np.float32(taps) - _HALF
        s, t = (u + step * long_u) / width, (v + step * long_v) / height
        one = texel_colour(textures, index, fine, s, t)
        if share > np.float32(0.02) and fine < last:
            two = texel_colour(textures, index, fine + 1, s, t)
            red += one[0] + share * (two[0] - one[0])
            green += one[1] + share * (two[1] - one[1])
            blue += one[2] + share * (two[2] - one[2])
        else:
            red += one[0]
            green += one[1]
            blue += one[2]
    scale = _ONE / np.float32(taps)
    return red * scale, green * scale, blue * scale


@kernel(error_model="numpy")
def overlay_colour(overlay, u, v, short_u, short_v, long_u, long_v):
    """Mean colour (times alpha) and alpha of the overlay under a footprint; 0 beyond its edges.

    As `filtered_colour`, but without repeats: taps outside of the picture add nothing.
    """
    # The footprint's axes in pixels of the finest level, the longer one last.
    across, down = overlay.scale[0], overlay.scale[1]
    short = np.sqrt((short_u * across) ** 2 + (short_v * down) ** 2)
    long = np.sqrt((long_u * across) ** 2 + (long_v * down) ** 2)
    if short > long:
        short, long = long, short
        long_u, long_v = short_u, short_v
    # The level on which the shorter axis is a pixel, and the taps along the longer one.
    short = max(short, long / np.float32(_MOST_TAPS), _ONE)
    level = min(np.int32(np.log2(short) + _HALF), len(overlay.first) - 1)
    taps = min(max(np.int32(long / short + _HALF), 1), _MOST_TAPS)
    height, width = overlay.shape[level, 0], overlay.shape[level, 1]
    halved = np.float32(1.0 / (1 << level))
    scale_x, scale_y = across * halved, down * halved
    first = overlay.first[level]
    red, green, blue = np.float32(0.0), np.float32(0.0), np.float32(0.0)
    alpha = np.float32(0.0)
    # Invariant: the sums hold, of each tap so far, the four pixels around it, bilinearly weighted.
    for tap in range(taps):
        step = (np.float32(tap) + _HALF) / np.float32(taps) - _HALF
        x = (u - overlay.begin[0] + step * long_u) * scale_x - _HALF
        y = (v + step * long_v) * scale_y - _HALF
        column, row = np.int32(np.floor(x)), np.int32(np.floor(y))
        if column < -1 or row < -1 or column >= width or row >= height:
            continue
        fx, fy = x - np.float32(column), y - np.float32(row)
        for dy in range(2):
            for dx in range(2):
                i = min(max(row + dy, 0), height - 1)
                j = min(max(column + dx, 0), width - 1)
                weight = (fx if dx else _ONE - fx) * (fy if dy else _ONE - fy)
                place = first + i * width + j
                red += weight * _LINEAR[overlay.texels[place, 0]]
                green += weight * _LINEAR[overlay.texels[place, 1]]
                blue += weight * _LINEAR[overlay.texels[place, 2]]
                alpha += weight * overlay.texels[place, 3]
    scale = _ONE / np.float32(taps)
    return red * scale, green * scale, blue * scale, alpha * scale / np.float32(255.0)


def no_overlay() -> OverlayArrays:
    """For scenes without any."""
    return OverlayArrays(
        np.zeros((1, 4), np.uint8),
        np.zeros(1, np.int64),
        np.ones((1, 2), np.int32),
        np.ones(2, np.float32),
        np.zeros(1, np.float32),
    )


__all__ = [
    "OverlayArrays",
    "TextureArrays",
    "filtered_colour",
    "no_overlay",
    "overlay_colour",
    "texel_colour",
]
