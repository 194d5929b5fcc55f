"""Textures of vehicles: flanks with door seams, windows, rims, lamps, grilles, tarpaulins."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

from avsec_gym.world.textures.noise import coloured, fractal_noise, picture, white_noise
from avsec_gym.world.textures.texture import Picture, Texture
from avsec_gym.world.textures.vehicle_lettering import (
    cargo_side,
    destination,
    plate,
    van_sign,
)

_Canvas = NDArray[np.float32]


def _car_side(variant: int, rng: np.random.Generator) -> Picture:
    """Flank of a car, 4 units long from tail to nose: seams, handles, dirt; white for the paint.

    Axles are at 0.8 and 3.1 + gap, the pillar between the doors at 2.1.
    """
    height, width = 128, 512
    scale = width / 4.0
    canvas = np.full((height, width, 3), 250.0, np.float32)
    seams = np.zeros((height, width), np.float32)

    def line(*points: tuple[float, float], thickness: int = 1) -> None:
        path = np.array([(u * scale, v * height) for u, v in points], np.float32)
        cv2.polylines(seams, [np.round(path).astype(np.int32)], False, 1.0, thickness, cv2.LINE_AA)

    if variant == 0:  # four doors
        line(
            (1.16, 0.0),
            (1.20, 0.18),
            (1.34, 0.45),
            (1.36, 0.85),
            (1.42, 0.9),
            (3.02, 0.9),
            (3.1, 0.8),
            (3.1, 0.0),
        )
        line((2.1, 0.0), (2.1, 0.9))
        handles = [1.3, 2.25]
    elif variant == 1:  # two doors
        line((1.98, 0.0), (2.0, 0.85), (2.06, 0.9), (3.02, 0.9), (3.1, 0.8), (3.1, 0.0))
        handles = [2.12]
    else:  # sliding door
        line((1.1, 0.0), (1.1, 0.88), (2.08, 0.88), (2.08, 0.0))
        line((2.1, 0.0), (2.1, 0.9), (3.02, 0.9), (3.08, 0.0))
        line((0.45, 0.22), (1.1, 0.22))
        handles = [1.98, 2.22]
    line((0.1, 0.55), (0.42, 0.5))
    line((3.62, 0.5), (3.9, 0.6))
    canvas *= 1.0 - 0.85 * seams[..., None]
    for handle in handles:
        x, y = int(handle * scale), int(0.2 * height)
        cv2.rectangle(canvas, (x - 1, y + 3), (x + 20, y + 7), (95, 95, 95), -1)
        cv2.rectangle(canvas, (x, y), (x + 19, y + 3), (235, 235, 235), -1)
    if variant < 2:
        cv2.rectangle(
            canvas, (int(0.62 * scale), 20), (int(0.62 * scale) + 17, 36), (130, 130, 130), 1
        )
    # The light catches the crease below the handles; the lower third is dusty.
    v = np.linspace(0.0, 1.0, height, dtype=np.float32)[:, None, None]
    canvas *= 1.0 - 0.10 * np.exp(-(((v - 0.36) / 0.05) ** 2))
    dust = np.clip((v - 0.62) / 0.38, 0.0, 1.0) * (
        0.8 + 0.12 * fractal_noise(rng, height, width, cells=6)[..., None]
    )
    canvas += (np.array([150, 142, 130], np.float32) - canvas) * 0.15 * np.clip(dust, 0, 1)
    canvas[int(0.94 * height) :] *= 0.35
    return picture(canvas)


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


def _wheel(variant: int, rng: np.random.Generator) -> Picture:
    """A rim of radius 0.66 in a square of 2: alloy spokes, or a steel wheel's cover."""
    size = 192
    axis = (np.arange(size, dtype=np.float32) + 0.5) / size * 2.0 - 1.0
    x, y = np.meshgrid(axis, axis)
    radius, angle = np.hypot(x, y), np.arctan2(y, x)
    spokes = (5, 5, 7, 10, 6, 8, 12, 9)[variant]
    metal = (190.0, 165.0, 200.0, 180.0, 150.0, 175.0, 160.0, 120.0)[variant]
    wave = np.cos(spokes * angle)
    if variant in (1, 3):  # double spokes
        wave = np.cos(2 * spokes * angle) * 0.6 + 0.5 * wave
    share = (0.1, 0.0, 0.0, 0.1, 0.55, 0.45, 0.6, 0.2)[variant]
    spoke = wave > -share + 0.5 * (radius - 0.4)
    holes = ~spoke & (radius > 0.2) & (radius < 0.56)
    if variant >= 4:  # covers: small holes near the edge
        holes &= (radius > 0.38) & (radius < 0.54)
    value = metal * (0.85 + 0.25 * np.clip(0.6 - radius, 0, 1)) + 6.0 * white_noise(
        rng, size, size, 1.5
    )
    value = np.where(holes, 22.0, value)
    value = np.where((radius > 0.615) & (radius < 0.64), metal * 1.15, value)
    value = np.where(radius > 0.64, 60.0, value)
    value = np.where(radius < 0.09, 70.0, value)
    bolts = (radius > 0.13) & (radius < 0.17) & (np.cos(5 * angle) > 0.8)
    value = np.where(bolts, 50.0, value)
    smooth = cv2.GaussianBlur(value, (0, 0), 0.8)
    return picture(np.repeat(smooth[..., None], 3, axis=2))


def _grille(variant: int, rng: np.random.Generator) -> Picture:
    """Dark gaps between bars: across, upright, a mesh, two broad slats."""
    height, width = 64, 128
    y, x = np.mgrid[0:height, 0:width].astype(np.float32)
    bars = (
        np.cos(y / height * 2 * np.pi * 5) > 0.25,
        np.cos(x / width * 2 * np.pi * 12) > 0.3,
        (np.cos(y / height * 2 * np.pi * 6) > 0.6) | (np.cos(x / width * 2 * np.pi * 12) > 0.6),
        np.cos(y / height * 2 * np.pi * 2) > 0.5,
    )[variant]
    value = np.where(bars, (120.0, 70.0, 45.0, 55.0)[variant], 12.0)
    value[:5] = value[-3:] = 165.0 if variant != 2 else 40.0
    value = value + 3.0 * white_noise(rng, height, width)
    return picture(np.repeat(value[..., None], 3, axis=2))


def _headlamp(variant: int, rng: np.random.Generator) -> Picture:
    """Reflectors behind clear glass; the indicator at the outer end is clear, amber, or below."""
    size = 96
    canvas = np.full((size, size, 3), 120.0, np.float32)
    canvas += 14.0 * white_noise(rng, size, size, 2.0)[..., None]
    for x, radius in ((36, 23), (72, 20)):
        cv2.circle(canvas, (x, 50), radius, (98, 100, 106), -1, cv2.LINE_AA)
        cv2.circle(canvas, (x, 50), radius - 3, (205, 210, 216), -1, cv2.LINE_AA)
        cv2.circle(canvas, (x, 52), radius // 2, (160, 165, 173), -1, cv2.LINE_AA)
        cv2.circle(canvas, (x, 50), 4, (250, 250, 250), -1, cv2.LINE_AA)
    if variant == 1:
        canvas[:, :11] = (190, 110, 40)
    elif variant == 2:
        canvas[76:, 20:] = (150, 95, 50)
    for edge in (np.s_[:6], np.s_[-6:], np.s_[:, :4], np.s_[:, -4:]):
        canvas[edge] *= 0.3
    return picture(canvas)


def _tail_lamp(variant: int, rng: np.random.Generator) -> Picture:
    """Red with an amber or a clear band, or all red with round lights."""
    size = 64
    canvas = np.full((size, size, 3), (165, 8, 10), np.float32)
    if variant == 0:
        canvas[20:31] = (185, 80, 20)
        canvas[31:40] = (200, 170, 165)
    elif variant == 1:
        canvas[36:50] = (205, 180, 178)
    else:
        for x in (18, 46):
            cv2.circle(canvas, (x, 34), 12, (215, 30, 26), -1, cv2.LINE_AA)
            cv2.circle(canvas, (x, 34), 5, (235, 120, 110), -1, cv2.LINE_AA)
    canvas *= 1.0 + 0.06 * white_noise(rng, size, size, 1.0)[..., None]
    for edge in (np.s_[:4], np.s_[-4:], np.s_[:, :3], np.s_[:, -3:]):
        canvas[edge] *= 0.35
    return picture(canvas)


def _bonnet(_: int, __: np.random.Generator) -> Picture:
    """Seen from above, windscreen at the top: shut lines, the dark gap below the wipers."""
    size = 256
    canvas = np.full((size, size, 3), 250.0, np.float32)
    for sign in (-1, 1):
        path = [
            (0.5 + sign * u, v) for u, v in ((0.445, 0.0), (0.44, 0.45), (0.42, 0.8), (0.40, 1.0))
        ]
        line = np.round(np.array(path) * size).astype(np.int32)
        cv2.polylines(canvas, [line], False, (90.0, 90.0, 90.0), 2, cv2.LINE_AA)
    canvas[:14] = 20.0
    return picture(canvas)


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
    "car_side": Texture((4.0, 1.0), 3, _car_side),
    "side_glass": Texture((1.0, 1.0), 3, _window((0.45,), (110.0, 60.0, 150.0))),
    "windscreen": Texture((1.0, 1.0), 3, _window((0.28, 0.72), (80.0, 45.0, 110.0), board=True)),
    "rear_glass": Texture((1.0, 1.0), 3, _window((0.25, 0.75), (75.0, 35.0, 55.0), wiper=True)),
    "wheel": Texture((2.0, 2.0), 8, _wheel),
    "grille": Texture((1.0, 1.0), 4, _grille),
    "bonnet": Texture((1.0, 1.0), 1, _bonnet),
    "headlamp": Texture((1.0, 1.0), 3, _headlamp),
    "tail_lamp": Texture((1.0, 1.0), 3, _tail_lamp),
    "cargo_side": Texture((8.0, 2.5), 8, cargo_side),
    "cargo_doors": Texture((2.5, 2.5), 1, _cargo_doors),
    "van_sign": Texture((1.0, 1.0), 6, van_sign),
    "tarpaulin": Texture((1.0, 1.0), 1, _tarpaulin),
    "bus_door": Texture((1.0, 1.0), 1, _bus_door),
    "destination": Texture((1.0, 1.0), 1, destination),
}
