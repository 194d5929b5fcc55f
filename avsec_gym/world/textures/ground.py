"""Textures of roads, paths and land: asphalt, stones, grass, soil."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from avsec_gym.world.textures.noise import coloured, fractal_noise, picture, white_noise
from avsec_gym.world.textures.paving import LAYINGS, Laying, bond, stones
from avsec_gym.world.textures.texture import Picture, Texture

_SIDE = 512
_GRAINS = 4
"""Pixels; of a size up to that grains of asphalt stay."""
_Image = NDArray[np.float32]

_ASPHALTS = (
    # red, green, blue, grain, its size in pixels, light stones, clouds
    (117, 115, 111, 0.148, 0.38, 0.6, 0.011),
    (103, 101, 98, 0.157, 0.44, 0.8, 0.011),
    (88, 87, 84, 0.165, 0.38, 0.5, 0.011),
    (125, 119, 108, 0.157, 0.38, 0.8, 0.015),
    (142, 138, 128, 0.140, 0.34, 0.4, 0.013),
    (108, 105, 98, 0.165, 0.44, 0.9, 0.016),
    (95, 93, 90, 0.148, 0.34, 0.5, 0.010),
    (131, 128, 119, 0.148, 0.34, 0.6, 0.013),
)
"""Asphalts from real streets: the last ones are an even dark top layer and a light worn one."""

_GRASSES = ((101, 110, 62), (111, 115, 68), (93, 105, 60), (115, 117, 70))
_MEADOWS = ((98, 102, 60), (114, 109, 68), (92, 94, 56), (126, 117, 76))
_FIELDS = ((134, 112, 84), (176, 156, 108), (98, 108, 54), (116, 96, 74))


def _asphalt(variant: int, rng: np.random.Generator) -> Picture:
    *colour, grain, size, light, clouds = _ASPHALTS[variant]
    return _bituminous(rng, colour, grain, size, light, clouds)


def _red_asphalt(_: int, rng: np.random.Generator) -> Picture:
    return _bituminous(rng, (134, 92, 82), 0.15, 0.40, 0.5, 0.03)


def _bituminous(
    rng: np.random.Generator,
    colour: Sequence[float],
    grain: float,
    size: float,
    light: float,
    clouds: float,
) -> Picture:
    """Stones of many greys in black bitumen; single ones catch the light."""
    fine = white_noise(rng, _SIDE, _SIDE, size)
    light_stones = np.maximum(white_noise(rng, _SIDE, _SIDE, 0.7) - 1.2, 0.0)
    pits = np.maximum(white_noise(rng, _SIDE, _SIDE, 0.8) - 1.5, 0.0)
    cloud = fractal_noise(rng, _SIDE, _SIDE, cells=5, octaves=6, persistence=0.6)
    level = _even(grain * (fine + light * light_stones - 0.7 * pits) + clouds * cloud)
    image = coloured(colour, level, 1.0)
    # Red, grey and blue stones.
    hue = white_noise(rng, _SIDE, _SIDE, 0.7)
    image *= 1.0 + 0.02 * hue[..., None] * np.array([1.0, 0.0, -1.0], np.float32)
    return picture(image)


def _even(level: _Image) -> _Image:
    """Without most of what is larger than grains: it would be seen to repeat.

    `avsec_gym.world.road.wear` lays blotches over roads that do not.
    """
    margin = 4 * _GRAINS
    wide = cv2.copyMakeBorder(level, margin, margin, margin, margin, cv2.BORDER_WRAP)
    blotches = cv2.GaussianBlur(wide, (0, 0), _GRAINS)[margin:-margin, margin:-margin]
    return np.asarray(level - blotches.mean() - 0.5 * (blotches - blotches.mean()), np.float32)


def _concrete(_: int, rng: np.random.Generator) -> Picture:
    """Cast lanes: fine, light, brushed across."""
    noise = white_noise(rng, _SIDE, _SIDE)
    brushed = np.mean([np.roll(noise, shift, axis=0) for shift in range(9)], axis=0)
    cloud = fractal_noise(rng, _SIDE, _SIDE, cells=4, persistence=0.7)
    level = 0.05 * white_noise(rng, _SIDE, _SIDE, 0.6) + 0.10 * brushed + 0.02 * cloud
    return picture(coloured((158, 154, 144), level, 1.0))


def _slabs(variant: int, rng: np.random.Generator) -> Picture:
    """Concrete slabs of pavements: square, in rows or diagonal, or oblong."""
    colour = ((160, 156, 148), (148, 145, 140), (170, 162, 150), (156, 153, 150))[variant]
    layout = bond(rng, _SIDE, 4.8, LAYINGS[f"slabs/{variant}"])
    return stones(
        rng, layout, colour, joint_colour=(84, 80, 70), joint=0.6, spread=0.02, grain=0.075
    )


def _setts(variant: int, rng: np.random.Generator) -> Picture:
    """Small granite cubes with wide joints of sand and moss."""
    colour = ((180, 173, 162), (140, 138, 136), (168, 155, 140))[variant]
    layout = bond(rng, _SIDE, 4.0, LAYINGS[f"setts/{variant}"], jitter=0.16)
    return stones(
        rng,
        layout,
        colour,
        joint_colour=(96, 90, 74),
        joint=1.3,
        spread=0.05,
        grain=0.10,
        round_=2.2,
    )


def _clinker(variant: int, rng: np.random.Generator) -> Picture:
    """Red-grey paving bricks, 20 by 10 centimetres."""
    colour = ((140, 110, 99), (136, 121, 113))[variant]
    layout = bond(rng, _SIDE, 4.0, LAYINGS[f"clinker/{variant}"], jitter=0.02)
    return stones(
        rng, layout, colour, joint_colour=(84, 76, 68), joint=1.0, spread=0.04, grain=0.10
    )


def _kerb_stone(_: int, rng: np.random.Generator) -> Picture:
    """Granite or concrete kerbs, a metre each, laid along u."""
    layout = bond(rng, _SIDE, 4.0, Laying(1.0, 4.0))
    return stones(
        rng, layout, (156, 152, 145), joint_colour=(76, 72, 66), joint=1.3, spread=0.06, grain=0.10
    )


def _grass(variant: int, rng: np.random.Generator) -> Picture:
    return _green(rng, _GRASSES[variant], 0.8, 0.15, 0.16)


def _meadow(variant: int, rng: np.random.Generator) -> Picture:
    return _green(rng, _MEADOWS[variant], 1.1, 0.18, 0.24)


def _green(
    rng: np.random.Generator,
    colour: tuple[int, int, int],
    blade: float,
    contrast: float,
    dryness: float,
) -> Picture:
    """Blades with dark gaps, in clumps, here and there dry or a herb of another green."""
    blades = white_noise(rng, _SIDE, _SIDE, blade) + 0.7 * white_noise(rng, _SIDE, _SIDE, 3.0)
    clumps = fractal_noise(rng, _SIDE, _SIDE, cells=14, octaves=5, persistence=0.75)
    dry = np.clip(
        dryness * (fractal_noise(rng, _SIDE, _SIDE, cells=11, octaves=6, persistence=0.85) + 0.6),
        0.0,
        1.0,
    )[..., None]
    straw = np.array([140, 124, 78], np.float32)
    base = np.array(colour, np.float32) * (1 - dry) + straw * dry
    level = contrast * blades + 0.34 * contrast * clumps
    image = base * np.maximum(1.0 + level[..., None], 0.18)
    hue = white_noise(rng, _SIDE, _SIDE, 1.5)[..., None]
    return picture(image * (1.0 + 0.07 * hue * np.array([1.0, 0.2, -0.6], np.float32)))


def _soil(variant: int, rng: np.random.Generator) -> Picture:
    """Bare earth with pebbles and straws."""
    colour = ((122, 102, 80), (102, 88, 72))[variant]
    cloud = fractal_noise(rng, _SIDE, _SIDE, cells=12, octaves=7, persistence=0.85)
    crumbs = white_noise(rng, _SIDE, _SIDE, 1.1)
    pebbles = np.maximum(white_noise(rng, _SIDE, _SIDE, 1.4) - 1.7, 0.0)
    return picture(coloured(colour, 0.11 * cloud + 0.13 * crumbs + 0.3 * pebbles, 1.0))


def _gravel(_: int, rng: np.random.Generator) -> Picture:
    """Crushed limestone: light stones, dark gaps."""
    pebbles = white_noise(rng, _SIDE, _SIDE, 1.0) + 0.7 * white_noise(rng, _SIDE, _SIDE)
    cloud = fractal_noise(rng, _SIDE, _SIDE, cells=5, persistence=0.7)
    return picture(coloured((150, 142, 126), 0.20 * pebbles + 0.07 * cloud, 1.0))


def _leaf_litter(_: int, rng: np.random.Generator) -> Picture:
    """Soil under brown and yellow leaves."""
    image = _soil(1, rng)
    hues = np.array([(150, 112, 62), (176, 142, 72), (112, 80, 50), (134, 92, 52), (190, 168, 96)])
    places = rng.uniform(0, _SIDE, (5200, 2))
    shades = hues[rng.integers(0, len(hues), len(places))] * rng.uniform(0.55, 1.1, (5200, 1))
    turns = rng.uniform(0, 180, len(places))
    axes = rng.uniform(1.4, 3.6, (len(places), 2)) * [1.0, 0.65]
    for place, shade, turn, axis in zip(places, shades, turns, axes, strict=True):
        for shift in _wrapped(place, 4.0):
            cv2.ellipse(
                image,
                np.round((place + shift) * 16).astype(int).tolist(),
                np.round(axis * 16).astype(int).tolist(),
                float(turn),
                0,
                360,
                shade.tolist(),
                -1,
                cv2.LINE_AA,
                4,
            )
    return image


def _field(variant: int, rng: np.random.Generator) -> Picture:
    """Ploughed, stubble, young green, harrowed: rows along u."""
    rows = (22, 40, 30, 64)[variant]
    wobble = 0.6 * fractal_noise(rng, _SIDE, _SIDE, cells=6, octaves=4)
    wave = np.sin(2 * np.pi * rows * np.arange(_SIDE)[:, None] / _SIDE + wobble)
    crumbs = white_noise(rng, _SIDE, _SIDE, 1.2) + 0.8 * fractal_noise(
        rng, _SIDE, _SIDE, cells=8, octaves=6, persistence=0.8
    )
    return picture(coloured(_FIELDS[variant], 0.10 * wave + 0.12 * crumbs, 1.0))


def _wrapped(place: NDArray[np.float64], margin: float) -> list[NDArray[np.float64]]:
    """Shifts at which something must be drawn; several near the edges."""
    axes = [
        [shift for shift in (-_SIDE, 0, _SIDE) if -margin < value + shift < _SIDE + margin]
        for value in place
    ]
    return [np.array([x, y], float) for x in axes[0] for y in axes[1]]


TEXTURES: dict[str, Texture] = {
    "asphalt": Texture((4.0, 4.0), len(_ASPHALTS), _asphalt),
    "red_asphalt": Texture((5.0, 5.0), 3, _red_asphalt),
    "road_concrete": Texture((6.0, 6.0), 3, _concrete),
    "slabs": Texture((4.8, 4.8), 4, _slabs),
    "setts": Texture((4.0, 4.0), 3, _setts),
    "clinker": Texture((4.0, 4.0), 2, _clinker),
    "kerb_stone": Texture((4.0, 4.0), 3, _kerb_stone),
    "grass": Texture((6.0, 6.0), len(_GRASSES), _grass),
    "meadow": Texture((8.0, 8.0), len(_MEADOWS), _meadow),
    "soil": Texture((6.0, 6.0), 2, _soil),
    "gravel": Texture((4.0, 4.0), 3, _gravel),
    "leaf_litter": Texture((5.0, 5.0), 3, _leaf_litter),
    "field": Texture((16.0, 16.0), len(_FIELDS), _field),
}
