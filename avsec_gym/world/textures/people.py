"""Textures: people.  Cloth, skin, hair and heads with their faces; cloth is light, for tinting."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from avsec_gym.world.textures.noise import Noise, coloured, fractal_noise, picture, white_noise
from avsec_gym.world.textures.texture import Picture, Texture

Colour = tuple[int, int, int]
Floats = NDArray[np.floating]


class HeadLook(NamedTuple):
    """Skin, hair (red, green, blue in 0..255 as on a screen) and what surrounds the face.

    `style` is one of short, receding, bald, long, bob, ponytail, bun.
    """

    skin: Colour
    hair: Colour
    style: str
    beard: bool = False
    glasses: str = ""


HEADS = (
    HeadLook((214, 168, 142), (72, 54, 42), "short"),
    HeadLook((222, 178, 152), (104, 80, 58), "short", glasses="clear"),
    HeadLook((206, 156, 130), (50, 43, 40), "short", beard=True),
    HeadLook((224, 182, 160), (150, 146, 140), "receding", glasses="clear"),
    HeadLook((210, 160, 136), (92, 84, 78), "receding"),
    HeadLook((218, 172, 148), (120, 104, 92), "bald"),
    HeadLook((188, 138, 108), (44, 39, 36), "short", glasses="sun"),
    HeadLook((118, 80, 60), (38, 35, 34), "short"),
    HeadLook((226, 186, 164), (176, 150, 106), "long"),
    HeadLook((220, 176, 152), (70, 46, 32), "long", glasses="sun"),
    HeadLook((214, 168, 144), (48, 41, 38), "ponytail"),
    HeadLook((226, 184, 162), (148, 116, 80), "ponytail"),
    HeadLook((220, 178, 156), (88, 56, 42), "bob"),
    HeadLook((216, 172, 150), (176, 172, 166), "bob", glasses="clear"),
    HeadLook((222, 180, 156), (88, 60, 40), "bun"),
    HeadLook((142, 100, 76), (42, 37, 36), "bun"),
)
"""What ``head/0`` and so on look like."""

HEAD_SIZE = (0.56, 0.32)
"""Circumference and height of the picture of a head; the face is in its middle."""


def _folds(rng: np.random.Generator, size: int, depth: float) -> Noise:
    """Light and dark of creases that run mostly across the limb."""
    soft = fractal_noise(rng, size, size, cells=3, octaves=3)
    ridges = np.abs(fractal_noise(rng, size, 2 * size, cells=5, octaves=3)[:, ::2])
    return np.asarray(1.0 + depth * (0.5 * soft + 1.1 * (ridges - ridges.mean())), np.float32)


def _cloth(variant: int, rng: np.random.Generator) -> Picture:
    size = 256
    weave = white_noise(rng, size, size)
    shade = _folds(rng, size, 0.10 + 0.03 * variant)
    return picture(coloured((224, 224, 224), weave, 0.03) * shade[..., None])


def _denim(variant: int, rng: np.random.Generator) -> Picture:
    """Worn lighter in large patches, with a diagonal weave."""
    size = 256
    y, x = np.mgrid[:size, :size]
    twill = np.where((x + y) % 4 < 2, 1.0, -1.0) + 0.6 * white_noise(rng, size, size)
    worn = 1.0 + (0.10 + 0.05 * variant) * fractal_noise(rng, size, size, cells=2, octaves=3)
    shade = _folds(rng, size, 0.10) * worn
    return picture(coloured((222, 228, 236), twill, 0.05) * shade[..., None])


def _knit(variant: int, rng: np.random.Generator) -> Picture:
    size = 192
    y, x = np.mgrid[:size, :size]
    period = (6, 12)[variant]
    ribs = np.sin(2.0 * np.pi * x / period) + 0.4 * np.sin(2.0 * np.pi * y / 4)
    shade = _folds(rng, size, 0.08)
    return picture(coloured((226, 226, 226), ribs, 0.07) * shade[..., None])


def _stripes(variant: int, rng: np.random.Generator) -> Picture:
    """Round the body: broad and dark, fine and pale, two widths."""
    size = 240
    second = ((40, 44, 60), (170, 176, 190), (60, 52, 50))[variant]
    period, share = ((60, 0.5), (12, 0.3), (40, 0.35))[variant]
    band = (np.arange(size) % period < share * period)[:, None, None]
    base = np.where(band, np.array(second), 236) * np.ones((1, size, 1))
    shade = _folds(rng, size, 0.10)
    return picture(base * shade[..., None])


def _checks(variant: int, rng: np.random.Generator) -> Picture:
    size, period = 240, (30, 40)[variant]
    line = (np.arange(size) % period < period // 2).astype(np.float32)
    dark = 1.0 - 0.30 * (line[:, None] + line[None, :])
    tones = ((238, 226, 220), (220, 228, 240))[variant]
    shade = dark * _folds(rng, size, 0.08)
    return picture(np.asarray(tones, np.float32) * shade[..., None])


def _leather(_: int, rng: np.random.Generator) -> Picture:
    grain = fractal_noise(rng, 96, 96, cells=8, octaves=4)
    return picture(coloured((224, 222, 218), grain, 0.06))


def _skin(_: int, rng: np.random.Generator) -> Picture:
    mottled = fractal_noise(rng, 96, 96, cells=3, octaves=4)
    return picture(np.array([244, 240, 238]) * (1.0 + 0.03 * mottled[..., None]))


def _hair(_: int, rng: np.random.Generator) -> Picture:
    """Strands run along the limb, that is down the picture."""
    strands = fractal_noise(rng, 16, 128, cells=24, octaves=3)
    strands = np.asarray(cv2.resize(strands, (128, 96)), np.float32)
    waves = fractal_noise(rng, 96, 128, cells=3, octaves=3)
    return picture(coloured((205, 205, 205), 0.8 * strands + 0.4 * waves, 0.16))


def _head(variant: int, rng: np.random.Generator) -> Picture:
    """Azimuth from the back of the head round to it, from the crown down to the neck."""
    look = HEADS[variant]
    height, width = 160, 288
    azimuth = (np.arange(width) + 0.5) / width * 2.0 * np.pi - np.pi
    level = 1.05 - (np.arange(height)[:, None] + 0.5) / height * 1.35
    across = np.abs(azimuth)[None, :]
    skin = np.broadcast_to(np.array(look.skin, np.float32), (height, width, 3)).copy()
    skin *= 1.0 + 0.02 * fractal_noise(rng, height, width, cells=6)[..., None]
    _draw_face(skin, azimuth[None, :], level, look)
    strands = fractal_noise(rng, height // 8, width, cells=60, octaves=2)
    strands = np.asarray(cv2.resize(strands, (width, height)), np.float32)
    hair = coloured(look.hair, strands, 0.09)
    fringe = 0.012 * white_noise(rng, 1, width, 3.0)
    covered = _soft((level - _hairline(azimuth, look)[None, :] - fringe) / 0.03)
    if look.beard:
        edge = np.interp(across, [0.0, 0.3, 0.6, 1.0, 1.45], [0.24, 0.23, 0.14, 0.20, 0.42])
        jaw = _soft((edge - level) / 0.05) * _soft((level + 0.04) / 0.06)
        jaw = jaw * _soft((1.55 - across) / 0.2)
        covered = np.maximum(covered, 0.75 * jaw)
    return picture(skin + covered[..., None] * (hair - skin))


def _draw_face(skin: NDArray[np.float32], azimuth: Floats, level: Floats, look: HeadLook) -> None:
    """Eyes in shaded sockets, brows, the nose's shadow, lips, ears and the shade of the chin."""

    def spot(centre: float, height: float, wide: float, high: float) -> Floats:
        distance = ((np.abs(azimuth) - centre) / wide) ** 2 + ((level - height) / high) ** 2
        return np.asarray(np.exp(-(distance**2)))

    def paint(mask: Floats, colour: Floats) -> None:
        skin[:] += mask[..., None] * (colour - skin)

    tone = np.array(look.skin, float)
    hair = np.array(look.hair, float)
    paint(0.35 * spot(0.36, 0.50, 0.24, 0.08), 0.55 * tone)
    paint(0.30 * spot(0.0, 0.29, 0.16, 0.035), 0.45 * tone)
    paint(0.20 * spot(0.85, 0.32, 0.25, 0.20), tone * [1.05, 0.85, 0.82])
    paint(0.75 * spot(0.36, 0.475, 0.14, 0.026), np.array([52.0, 42.0, 38.0]))
    paint(0.70 * spot(0.36, 0.575, 0.20, 0.022), 0.6 * hair)
    paint(0.75 * spot(0.0, 0.165, 0.24, 0.022), tone * [0.72, 0.48, 0.46])
    paint(0.30 * spot(1.55, 0.40, 0.12, 0.10), 0.6 * tone)
    paint(0.40 * _soft((-0.02 - level) / 0.05) * np.ones_like(azimuth), 0.6 * tone)
    if look.glasses:
        lens, dark = spot(0.36, 0.475, 0.29, 0.075), np.array([26.0, 24.0, 26.0])
        rim = np.clip(lens - spot(0.36, 0.475, 0.22, 0.055), 0, 1)
        temple = (np.abs(level - 0.51) < 0.016) & (np.abs(azimuth) > 0.6) & (np.abs(azimuth) < 1.5)
        paint((lens if look.glasses == "sun" else 0.8 * rim), dark)
        paint(0.8 * temple, dark)


def _hairline(azimuth: Floats, look: HeadLook) -> Floats:
    """Lowest level that is covered by hair, at each azimuth (0 in front)."""
    turns = [0.0, 0.45, 0.75, 1.0, 1.25, 1.42, 1.75, 2.1, np.pi]
    lines = {
        "short": [0.80, 0.80, 0.74, 0.62, 0.55, 0.36, 0.34, 0.14, 0.06],
        "receding": [0.93, 0.98, 0.95, 0.72, 0.58, 0.38, 0.36, 0.16, 0.08],
        "bald": [1.2, 1.2, 1.2, 1.1, 0.75, 0.40, 0.38, 0.18, 0.10],
        "long": [0.84, 0.76, 0.62, 0.48, 0.30, 0.02, -0.1, -0.3, -0.3],
        "bob": [0.66, 0.64, 0.58, 0.46, 0.22, 0.02, -0.05, -0.1, -0.1],
        "ponytail": [0.84, 0.82, 0.74, 0.64, 0.56, 0.46, 0.34, 0.16, 0.10],
        "bun": [0.82, 0.80, 0.72, 0.62, 0.55, 0.46, 0.34, 0.16, 0.10],
    }
    return np.interp(np.abs(azimuth), turns, lines[look.style])


def _soft(values: Floats) -> Floats:
    """0 below 0, 1 above 1, smooth between."""
    share = np.clip(values, 0.0, 1.0)
    return share * share * (3.0 - 2.0 * share)


TEXTURES: dict[str, Texture] = {
    "fabric": Texture((0.7, 0.7), 3, _cloth),
    "denim": Texture((0.6, 0.6), 2, _denim),
    "knit": Texture((0.5, 0.5), 2, _knit),
    "stripes": Texture((0.48, 0.48), 3, _stripes),
    "checks": Texture((0.48, 0.48), 2, _checks),
    "leather": Texture((0.3, 0.3), 3, _leather),
    "skin": Texture((0.3, 0.3), 3, _skin),
    "hair": Texture((0.25, 0.2), 3, _hair),
    "head": Texture(HEAD_SIZE, len(HEADS), _head),
}
