"""Textures of cars: flanks with door seams, panes, rims, lamps, grilles."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from avsec_gym.world.textures.noise import fractal_noise, picture, white_noise
from avsec_gym.world.textures.texture import Picture, Texture

_Canvas = NDArray[np.float32]
_Colour = tuple[float, float, float]
_GREENISH: _Colour = (222.0, 232.0, 226.0)
_TINTS: tuple[_Colour, ...] = (_GREENISH, (190.0, 204.0, 198.0), (84.0, 88.0, 90.0))
"""Tints of panes: clear, tinted, and dark ones that keep the sun out."""
_FRIT = 14.0
"""Brightness of the black print round a pane's edge."""


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
    # A shade lies in the hollow below the handles; the lower third is dusty.
    v = np.linspace(0.0, 1.0, height, dtype=np.float32)[:, None, None]
    canvas *= 1.0 - 0.04 * np.exp(-(((v - 0.36) / 0.05) ** 2))
    dust = np.clip((v - 0.62) / 0.38, 0.0, 1.0) * (
        0.8 + 0.12 * fractal_noise(rng, height, width, cells=6)[..., None]
    )
    canvas += (np.array([150, 142, 130], np.float32) - canvas) * 0.15 * np.clip(dust, 0, 1)
    canvas[int(0.94 * height) :] *= 0.35
    return picture(canvas)


def _pane(tint: _Colour, frame: int) -> _Canvas:
    """Tinted glass with a black frame of so many pixels."""
    canvas = np.empty((128, 128, 3), np.float32)
    canvas[:] = tint
    for edge in (np.s_[:frame], np.s_[-frame:], np.s_[:, :frame], np.s_[:, -frame:]):
        canvas[edge] = _FRIT
    return canvas


def _side_pane(variant: int, _: np.random.Generator) -> Picture:
    """A side window in its rubber."""
    return picture(_pane(_TINTS[variant], 4))


def _wind_pane(variant: int, _: np.random.Generator) -> Picture:
    """A windscreen: rear-view mirror, a sticker, wipers; one has a darker band above."""
    canvas = _pane(_GREENISH, 5)
    if variant == 1:
        canvas[5:20, 5:-5] *= np.linspace(0.35, 1.0, 15, dtype=np.float32)[:, None, None]
    canvas[121:] = _FRIT
    cv2.ellipse(canvas, (64, 16), (9, 5), 0, 0, 360, (_FRIT,) * 3, -1, cv2.LINE_AA)
    cv2.line(canvas, (64, 0), (64, 14), (_FRIT,) * 3, 3)
    cv2.circle(canvas, (116, 112), 4, (40.0, 150.0, 60.0), -1, cv2.LINE_AA)
    for wiper in (((20, 119), (70, 113)), ((66, 119), (112, 114))):
        cv2.line(canvas, *wiper, (10.0,) * 3, 2, cv2.LINE_AA)
    return picture(canvas)


def _rear_pane(variant: int, _: np.random.Generator) -> Picture:
    """A rear window: wires of its heater, a high brake lamp, a wiper."""
    canvas = _pane(_TINTS[variant], 6)
    for row in range(18, 116, 11):
        canvas[row, 8:-8] *= 0.8
    cv2.rectangle(canvas, (52, 5), (76, 10), (120.0, 14.0, 14.0), -1)
    cv2.line(canvas, (64, 122), (96, 112), (8.0,) * 3, 3, cv2.LINE_AA)
    return picture(canvas)


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


def _bezel(value: float, rng: np.random.Generator) -> _Canvas:
    """The inside of a lamp: a housing of one brightness under ribbed glass."""
    canvas = np.full((96, 96, 3), value, np.float32)
    canvas += 0.08 * value * white_noise(rng, 96, 96, 2.0)[..., None]
    return canvas


def _reflector(canvas: _Canvas, x: int, y: int, radius: int) -> None:
    """A bowl that is bright above and dark below, as the sky and the road lie in it."""
    cv2.circle(canvas, (x, y), radius, (74.0, 77.0, 82.0), -1, cv2.LINE_AA)
    cv2.circle(canvas, (x, y - 1), radius - 2, (222.0, 226.0, 232.0), -1, cv2.LINE_AA)
    cv2.ellipse(
        canvas, (x, y + radius // 3), (radius - 4, radius // 2), 0, 0, 360,
        (128.0, 132.0, 140.0), -1, cv2.LINE_AA,
    )  # fmt: skip
    cv2.circle(canvas, (x, y), max(radius // 4, 2), (250.0, 250.0, 250.0), -1, cv2.LINE_AA)


def _projector(canvas: _Canvas, x: int, y: int, radius: int) -> None:
    """A lens in a dark ring with the sky's highlight on it."""
    cv2.circle(canvas, (x, y), radius, (170.0, 173.0, 178.0), 2, cv2.LINE_AA)
    cv2.circle(canvas, (x, y), radius - 3, (38.0, 42.0, 52.0), -1, cv2.LINE_AA)
    cv2.circle(
        canvas, (x - radius // 4, y - radius // 3), radius // 3, (205.0, 215.0, 230.0), -1,
        cv2.LINE_AA,
    )  # fmt: skip


def _headlamp(variant: int, rng: np.random.Generator) -> Picture:
    """What is behind a headlamp's clear glass, from its inner end to its outer one."""
    canvas = _bezel((150.0, 62.0, 140.0, 120.0, 130.0, 40.0, 60.0)[variant], rng)
    amber = (214.0, 118.0, 34.0)
    if variant == 0:  # two bowls, clear indicator
        _reflector(canvas, 28, 50, 21)
        _reflector(canvas, 64, 48, 23)
    elif variant == 1:  # dark housing, one lens and one bowl, drawn outwards
        _reflector(canvas, 26, 56, 18)
        _projector(canvas, 60, 46, 18)
        cv2.ellipse(canvas, (86, 40), (7, 22), 0, 0, 360, (200.0, 160.0, 110.0), -1, cv2.LINE_AA)
    elif variant == 2:  # one large bowl over the indicator
        _reflector(canvas, 48, 40, 30)
        canvas[74:, 14:82] = amber
    elif variant == 3:  # a round lamp and a small indicator
        _reflector(canvas, 46, 48, 36)
        canvas[34:62, 84:] = amber
    elif variant == 4:  # ribbed rectangle, amber corner
        canvas += 30.0 * np.cos(np.arange(96, dtype=np.float32) * 0.7)[None, :, None]
        _reflector(canvas, 40, 48, 26)
        canvas[:, 74:] = amber
    elif variant == 5:  # two lenses in a black housing
        _projector(canvas, 30, 50, 20)
        _projector(canvas, 68, 48, 20)
        canvas[82:88, 8:88] = (225.0, 228.0, 235.0)
    else:  # fog lamp
        _reflector(canvas, 48, 48, 38)
    for edge in (np.s_[:4], np.s_[-4:], np.s_[:, :4], np.s_[:, -4:]):
        canvas[edge] *= 0.3
    return picture(canvas)


def _tail_lamp(variant: int, rng: np.random.Generator) -> Picture:
    """Red glass, with the indicator and the reversing lamp in it."""
    size = 64
    canvas = np.full((size, size, 3), (168, 8, 10), np.float32)
    clear, amber = (205.0, 188.0, 184.0), (205.0, 96.0, 22.0)
    if variant == 0:  # bands
        canvas[20:30], canvas[30:40] = amber, clear
    elif variant == 1:  # clear foot
        canvas[40:58] = clear
        canvas[8:14] = (225.0, 60.0, 50.0)
    elif variant == 2:  # round lights
        for y in (18, 46):
            cv2.circle(canvas, (32, y), 15, (110.0, 4.0, 6.0), 2, cv2.LINE_AA)
            cv2.circle(canvas, (32, y), 9, (225.0, 40.0, 34.0), -1, cv2.LINE_AA)
        cv2.circle(canvas, (32, 46), 6, clear, -1, cv2.LINE_AA)
    elif variant == 3:  # blocks side by side, ribbed
        canvas[6:-6, 6:22], canvas[34:-6, 24:40] = amber, clear
        canvas *= 1.0 + 0.12 * np.cos(np.arange(size, dtype=np.float32) * 1.1)[:, None, None]
    else:  # dark glass with rods of light
        canvas[:] = (112.0, 4.0, 8.0)
        canvas[16:22, 6:-6] = canvas[34:40, 6:-6] = (236.0, 52.0, 44.0)
        canvas[46:56, 8:30] = clear
    canvas *= 1.0 + 0.06 * white_noise(rng, size, size, 1.0)[..., None]
    for edge in (np.s_[:3], np.s_[-3:], np.s_[:, :2], np.s_[:, -2:]):
        canvas[edge] *= 0.3
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
        cv2.polylines(canvas, [line], False, (60.0, 60.0, 60.0), 1, cv2.LINE_AA)
    canvas[:9, 24:-24] = 20.0
    return picture(canvas)


TEXTURES: dict[str, Texture] = {
    "car_side": Texture((4.0, 1.0), 3, _car_side),
    "side_pane": Texture((1.0, 1.0), 3, _side_pane),
    "wind_pane": Texture((1.0, 1.0), 2, _wind_pane),
    "rear_pane": Texture((1.0, 1.0), 3, _rear_pane),
    "wheel": Texture((2.0, 2.0), 8, _wheel),
    "grille": Texture((1.0, 1.0), 4, _grille),
    "bonnet": Texture((1.0, 1.0), 1, _bonnet),
    "headlamp": Texture((1.0, 1.0), 7, _headlamp),
    "tail_lamp": Texture((1.0, 1.0), 5, _tail_lamp),
}
