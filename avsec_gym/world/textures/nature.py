"""Textures: bark, leaves and needles, hedge and ivy, grass blades, far forest and meadow.

Leaves are painted from the dark inside of the plant to its sunlit outside, so that the edges of
a leafy triangle dissolve into the shade behind it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import cv2
import numpy as np
from numpy.typing import NDArray

from avsec_gym.world.textures.noise import coloured, fractal_noise, picture, white_noise
from avsec_gym.world.textures.texture import Picture, Texture

Colour = tuple[float, float, float]
Outline = NDArray[np.float64]
"""A leaf that points to +x from its stalk at 0 to its tip at 1, shape (n, 2)."""

_PIXELS = 256
_SHADE = 0.2
_BRIGHTNESS = 1.4
_PALENESS = 0.22
"""Share of grey in the leaves: waxy leaves mirror the sky, and cameras' tone curves are hard."""


@dataclass(frozen=True)
class _Leaf:
    """How the leaves of a species look: colours in sRGB, lengths in shares of the picture."""

    deep: Colour
    fresh: Colour
    outline: Outline
    length: float
    count: int = 700
    accent: Colour | None = None
    """Accent of one leaf in eight (turning leaves, blossom)."""


def _leaves(variant: int, rng: np.random.Generator, *, leaf: _Leaf) -> Picture:
    """Leaves over leaves, the later the lighter."""
    count = leaf.count
    canvas = np.empty((_PIXELS, _PIXELS, 3), np.float32)
    canvas[:] = np.multiply(leaf.deep, _SHADE)
    place = rng.uniform(0, _PIXELS, (count, 2))
    height = np.linspace(0.0, 1.0, count)
    ripeness = np.clip(height + rng.normal(0, 0.35, count), 0, 1)[:, None]
    light = _BRIGHTNESS * (0.35 + 0.65 * height) * rng.lognormal(0, 0.18, count)
    colour = (np.multiply(leaf.deep, 1 - ripeness) + np.multiply(leaf.fresh, ripeness)) * light[
        :, None
    ]
    if leaf.accent is not None:
        turned = rng.random(count) < 0.125
        colour[turned] = np.multiply(leaf.accent, light[turned, None])
    colour += _PALENESS * (colour.mean(axis=1, keepdims=True) - colour)
    angle = rng.uniform(0, 2 * np.pi, count)
    size = leaf.length * _PIXELS * rng.uniform(0.7, 1.25, count)
    cos, sin = np.cos(angle) * size, np.sin(angle) * size
    turn = np.stack([np.stack([cos, sin], -1), np.stack([-sin, cos], -1)], 1)
    upper = leaf.outline[: len(leaf.outline) // 2 + 1]
    for number in range(count):
        whole = leaf.outline @ turn[number] + place[number]
        half = upper @ turn[number] + place[number]
        for shift in _shifts(whole):
            _fill(canvas, whole + shift, colour[number])
            _fill(canvas, half + shift, colour[number] * 0.82)
    return picture(canvas * (1 + 0.08 * white_noise(rng, _PIXELS, _PIXELS, 0.7)[..., None]))


def _shifts(shape: Outline) -> list[tuple[int, int]]:
    """Where a shape must be drawn so that it goes on at the opposite edge."""
    low, high = shape.min(axis=0), shape.max(axis=0)
    ways = [
        [0] + [_PIXELS] * bool(low[axis] < 0) + [-_PIXELS] * bool(high[axis] >= _PIXELS)
        for axis in (0, 1)
    ]
    return [(x, y) for x in ways[0] for y in ways[1]]


def _fill(canvas: NDArray[np.float32], corners: Outline, colour: NDArray[np.float64]) -> None:
    cv2.fillPoly(canvas, [np.round(corners * 16).astype(np.int32)], colour.tolist(), cv2.LINE_8, 4)


def _oval(width: float) -> Outline:
    along = np.array([0.0, 0.15, 0.45, 0.75, 1.0, 0.75, 0.45, 0.15])
    across = np.array([0.0, 0.7, 1.0, 0.55, 0.0, -0.55, -1.0, -0.7])
    return np.stack([along, 0.5 * width * across], axis=1)


def _lobed() -> Outline:
    along = np.array([0.0, 0.0, 0.3, 0.55, 0.6, 1.0, 0.6, 0.55, 0.3, 0.0])
    across = np.array([0.0, 0.35, 0.25, 0.55, 0.2, 0.0, -0.2, -0.55, -0.25, -0.35])
    return np.stack([along, across], axis=1)


_OVAL, _LOBED, _NEEDLE = _oval(0.75), _lobed(), _oval(0.16)
_FOLIAGE = {
    "lime": _Leaf((50, 68, 30), (100, 114, 48), _OVAL, 0.075),
    "maple": _Leaf((48, 63, 29), (94, 105, 46), _LOBED, 0.11, 420),
    "birch": _Leaf((66, 80, 34), (122, 128, 58), _oval(0.8), 0.045, 1500),
    "plane": _Leaf((62, 76, 36), (116, 122, 60), _LOBED, 0.13, 330, (128, 116, 50)),
    "poplar": _Leaf((48, 66, 34), (92, 110, 56), _oval(0.9), 0.055, 1000),
    "copper_beech": _Leaf((44, 24, 24), (92, 48, 42), _OVAL, 0.07, 750),
    "fruit": _Leaf((58, 74, 36), (106, 118, 58), _oval(0.55), 0.07, 800),
    "willow": _Leaf((72, 82, 38), (126, 128, 60), _oval(0.2), 0.1, 900),
    "autumn": _Leaf((84, 72, 26), (158, 124, 36), _LOBED, 0.1, 480, (150, 84, 30)),
    "shrub": _Leaf((46, 62, 30), (92, 104, 46), _OVAL, 0.05, 1300),
    "hedge": _Leaf((40, 56, 28), (84, 98, 42), _OVAL, 0.035, 2400, (96, 82, 44)),
    "ivy": _Leaf((36, 52, 26), (74, 92, 44), _LOBED, 0.07, 900),
    "spruce": _Leaf((30, 44, 30), (62, 78, 46), _NEEDLE, 0.09, 1700),
    "pine": _Leaf((34, 50, 32), (72, 88, 52), _NEEDLE, 0.12, 1500),
}


def _rough_bark(variant: int, rng: np.random.Generator) -> Picture:
    """Ridges that run upwards and meet: lime, maple, oak."""
    base = [(96, 84, 70), (82, 78, 72), (70, 60, 50)][variant]
    warp = fractal_noise(rng, 256, 128, cells=6)
    ridges = cv2.resize(white_noise(rng, 16, 128, 1.3), (128, 256), interpolation=cv2.INTER_CUBIC)
    grain = fractal_noise(rng, 256, 128, cells=40, octaves=3, persistence=0.8)
    return picture(coloured(base, np.tanh(ridges) + 0.4 * warp + 0.35 * grain, 0.24))


def _smooth_bark(variant: int, rng: np.random.Generator) -> Picture:
    """Grey beech (0), or plane whose plates peel off (1)."""
    cloud = fractal_noise(rng, 256, 256, cells=5, octaves=5)
    if variant == 0:
        streak = cv2.resize(white_noise(rng, 256, 8), (256, 256), interpolation=cv2.INTER_LINEAR)
        return picture(coloured((104, 102, 94), cloud + 0.3 * streak, 0.12))
    plates = np.digitize(cloud, [-0.7, 0.1, 0.9])
    colours = np.array([(150, 142, 108), (118, 112, 88), (92, 88, 72), (72, 68, 56)], np.float32)
    return picture(colours[plates] * (1 + 0.05 * white_noise(rng, 256, 256)[..., None]))


def _birch_bark(_: int, rng: np.random.Generator) -> Picture:
    """White paper, black lenticels across, dark cracked patches."""
    canvas = coloured((206, 203, 194), fractal_noise(rng, 256, 128, cells=6), 0.07)
    for _number in range(70):
        x, y = rng.integers(0, 128), rng.integers(4, 252)
        half = (int(rng.integers(2, 13)), int(rng.integers(1, 3)))
        for shift in (-128, 0, 128):
            cv2.ellipse(canvas, (int(x) + shift, int(y)), half, 0, 0, 360, (58, 54, 50), -1)
    patches = fractal_noise(rng, 256, 128, cells=7, octaves=4)
    canvas[patches > 1.5] *= 0.28
    return picture(canvas)


def _pine_bark(_: int, rng: np.random.Generator) -> Picture:
    """Reddish scales with dark joints."""
    cloud = fractal_noise(rng, 256, 128, cells=10, octaves=3)
    scales = 1.0 - np.clip(1.6 - 5.0 * np.abs(cloud), 0, 1) * 0.55
    flakes = fractal_noise(rng, 256, 128, cells=24, octaves=3, persistence=0.7)
    return picture(coloured((128, 88, 64), flakes, 0.16) * scales[..., None])


def _blades(_: int, rng: np.random.Generator) -> Picture:
    """Grass from root (bottom) to tip: each column a blade."""
    blade = white_noise(rng, 1, 64)[0][None, :, None]
    height = np.linspace(1.0, 0.0, 64)[:, None, None]
    dry = np.clip(0.25 * white_noise(rng, 1, 64)[0] + 0.2, 0, 1)[None, :, None] * height
    green = np.array([52, 70, 30], np.float32) + height * np.array([38, 44, 20], np.float32)
    straw = np.array([142, 130, 82], np.float32)
    return picture((green * (1 - dry) + straw * dry) * (1 + 0.16 * blade))


def _far_forest(variant: int, rng: np.random.Generator) -> Picture:
    """Crowns behind crowns, each lit from above: mixed wood (0), conifers (1)."""
    height, width = 256, 512
    canvas = np.empty((height, width, 3), np.float32)
    canvas[:] = (17, 23, 15)
    palette = np.array(
        [(50, 63, 36), (58, 69, 36), (42, 56, 34), (68, 70, 36), (36, 49, 32)]
        if variant == 0
        else [(38, 52, 36), (44, 58, 38), (32, 46, 34), (52, 62, 38), (28, 40, 30)],
        np.float64,
    )
    count, slim = (1100, 1.0) if variant == 0 else (1900, 0.55)
    depth = np.sort(rng.uniform(0, height, count))
    for y in depth:
        x, radius = rng.uniform(0, width), rng.uniform(6, 13) * (0.6 + 0.4 * slim)
        colour = palette[rng.integers(len(palette))] * rng.uniform(0.8, 1.15)
        for step in range(4):
            share = step / 3
            light = (colour * (0.35 + 0.8 * share)).tolist()
            half = (radius * slim * (1 - 0.55 * share), radius * (1 - 0.55 * share))
            centre = (x - 0.2 * radius * share, y - 0.35 * radius * share)
            for across in (-width, 0, width):
                for down in (-height, 0, height):
                    box = ((centre[0] + across, centre[1] + down), (2 * half[0], 2 * half[1]), 0)
                    if -40 < box[0][0] < width + 40 and -40 < box[0][1] < height + 40:
                        cv2.ellipse(canvas, box, light, -1)
    speckle = fractal_noise(rng, height, width, cells=110, octaves=2, persistence=0.8)
    tone = fractal_noise(rng, height, width, cells=4, octaves=3)
    return picture(canvas * (1 + 0.34 * speckle + 0.12 * tone)[..., None])


def _far_meadow(_: int, rng: np.random.Generator) -> Picture:
    """Fields and meadows from afar: broad tones, the mower's stripes."""
    tone = fractal_noise(rng, 256, 256, cells=3, octaves=7, persistence=0.55)
    stripes = np.sin(np.arange(256) * (2 * np.pi * 24 / 256))[None, :]
    ground = coloured((102, 108, 66), tone + 0.25 * stripes, 0.12)
    dry = np.clip(0.5 * fractal_noise(rng, 256, 256, cells=5, octaves=4), 0, 0.7)[..., None]
    return picture(ground * (1 - dry) + np.array([146, 132, 84], np.float32) * dry)


TEXTURES: dict[str, Texture] = {
    **{
        f"leaves_{name}": Texture((1.1, 1.1), 3, partial(_leaves, leaf=leaf))
        for name, leaf in _FOLIAGE.items()
    },
    "bark_rough": Texture((0.5, 1.0), 3, _rough_bark),
    "bark_smooth": Texture((1.0, 1.0), 2, _smooth_bark),
    "bark_birch": Texture((0.5, 1.0), 3, _birch_bark),
    "bark_pine": Texture((0.5, 1.0), 3, _pine_bark),
    "grass_blades": Texture((0.64, 0.25), 3, _blades),
    "forest_far": Texture((120.0, 60.0), 2, _far_forest),
    "meadow_far": Texture((120.0, 120.0), 3, _far_meadow),
}
