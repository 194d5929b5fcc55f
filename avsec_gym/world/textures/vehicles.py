"""Textures of lorries and buses: dark windows, doors, tarpaulins, lettering."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

from avsec_gym.world.textures.noise import coloured, fractal_noise, picture
from avsec_gym.world.textures.texture import Picture, Texture
from avsec_gym.world.textures.vehicle_lettering import (
    cargo_side,
    destination,
    plate,
    van_sign,
)

_Canvas = NDArray[np.float32]


def _seat_shapes(canvas: _Canvas, places: tuple[float, ...], colour: float) -> None:
    height, width = canvas.shape[:2]
    for u in places:
        x = int(u * width)
        cv2.ellipse(
            canvas,
            (x, int(0.52 * height)),
            (int(0.07 * width), int(0.14 * height)),
            0,
            0,
            360,
            (colour,) * 3,
            -1,
            cv2.LINE_AA,
        )
        cv2.ellipse(
            canvas,
            (x, height),
            (int(0.13 * width), int(0.34 * height)),
            0,
            0,
            360,
            (colour,) * 3,
            -1,
            cv2.LINE_AA,
        )


def _through(rng: np.random.Generator, brightness: float) -> _Canvas:
    """What is seen through two windows: the bright street in patches, darkness below."""
    size = 128
    v = np.linspace(0.0, 1.0, size, dtype=np.float32)[:, None]
    clouds = fractal_noise(rng, size, size, cells=3, octaves=4)
    light = 18.0 + brightness * np.clip(0.75 - 0.9 * v + 0.22 * clouds, 0.0, 1.0)
    return coloured((0.92, 1.0, 1.02), light / 1.0 - 1.0, 1.0)


def _window(
    places: tuple[float, ...],
    brightness: tuple[float, ...],
    *,
    board: bool = False,
    wiper: bool = False,
) -> Callable[[int, np.random.Generator], Picture]:
    """A window with seats behind it, a dashboard below it, or a wiper on it."""

    def make(variant: int, rng: np.random.Generator) -> Picture:
        canvas = _through(rng, brightness[variant])
        _seat_shapes(canvas, places, 12.0)
        if board:
            canvas[110:] = 26.0
        if wiper:
            cv2.line(canvas, (64, 122), (98, 112), (8.0,) * 3, 3, cv2.LINE_AA)
        frame = 4
        for edge in (np.s_[:frame], np.s_[-frame:], np.s_[:, :frame], np.s_[:, -frame:]):
            canvas[edge] = 9.0
        return picture(canvas)

    return make


def _cargo_doors(_: int, rng: np.random.Generator) -> Picture:
    """Two rear doors with locking bars and hinges, red and white warning plates."""
    size = 192
    canvas = np.full((size, size, 3), (205, 206, 204), np.uint8)
    cv2.rectangle(canvas, (1, 1), (size - 2, size - 2), (90, 90, 92), 5)
    cv2.line(canvas, (96, 0), (96, size), (70, 70, 70), 2)
    for x in (40, 74, 118, 152):
        cv2.line(canvas, (x, 6), (x, size - 6), (140, 142, 145), 3)
    cv2.line(canvas, (60, 140), (86, 140), (60, 60, 60), 4)
    cv2.line(canvas, (106, 140), (132, 140), (60, 60, 60), 4)
    for x in (10, 150):
        cv2.rectangle(canvas, (x, 168), (x + 30, 182), (225, 225, 225), -1)
        cv2.rectangle(canvas, (x, 168), (x + 14, 182), (190, 30, 25), -1)
    shade = 1.0 + 0.05 * fractal_noise(rng, size, size, cells=3)
    return picture(canvas.astype(np.float32) * shade[..., None])


def _tarpaulin(_: int, rng: np.random.Generator) -> Picture:
    """Cloth in soft upright folds."""
    size = 128
    x = np.arange(size, dtype=np.float32)[None, :] * (2 * np.pi / size)
    clouds = fractal_noise(rng, size, size, cells=4)
    folds = np.cos(3 * x + 0.6 * clouds) + 0.6 * np.cos(7 * x + 0.5 * clouds)
    return picture(coloured((205, 205, 205), folds, 0.09))


def _bus_door(_: int, rng: np.random.Generator) -> Picture:
    """Two door wings of glass in black frames."""
    canvas = _through(rng, 45.0)
    for x in (0, 60, 122):
        canvas[:, x : x + 6] = 10.0
    canvas[:5] = canvas[-6:] = 10.0
    return picture(canvas)


TEXTURES: dict[str, Texture] = {
    "plate": Texture((0.52, 0.115), 144, plate),
    "side_glass": Texture((1.0, 1.0), 3, _window((0.45,), (110.0, 60.0, 150.0))),
    "windscreen": Texture((1.0, 1.0), 3, _window((0.28, 0.72), (80.0, 45.0, 110.0), board=True)),
    "rear_glass": Texture((1.0, 1.0), 3, _window((0.25, 0.75), (75.0, 35.0, 55.0), wiper=True)),
    "cargo_side": Texture((8.0, 2.5), 8, cargo_side),
    "cargo_doors": Texture((2.5, 2.5), 1, _cargo_doors),
    "van_sign": Texture((1.0, 1.0), 6, van_sign),
    "tarpaulin": Texture((1.0, 1.0), 1, _tarpaulin),
    "bus_door": Texture((1.0, 1.0), 1, _bus_door),
    "destination": Texture((1.0, 1.0), 1, destination),
}
