"""Textures that fill an opening once: panes, doors, shop windows, shutters, signs."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from avsec_gym.world.textures.noise import coloured, fractal_noise, picture, white_noise
from avsec_gym.world.textures.texture import Picture

Canvas = NDArray[np.float32]
"""Shape (h, w, 3), 0 to 255, to be painted on."""

_NAMES = (
    "CAFE",
    "OPTIK",
    "Apotheke",
    "BLUMEN",
    "MODE",
    "Salon Eva",
    "PIZZERIA",
    "BUCH + BILD",
    "Foto",
    "BIO MARKT",
    "METALLBAU",
    "SPEDITION",
    "Elektro",
)
_SIGN_COLOURS = (
    ((238, 236, 228), (60, 40, 30)),
    ((30, 60, 130), (240, 240, 240)),
    ((240, 240, 240), (190, 30, 30)),
    ((70, 120, 60), (240, 236, 210)),
    ((24, 24, 26), (228, 226, 220)),
    ((236, 226, 200), (120, 40, 90)),
    ((180, 34, 30), (246, 240, 226)),
    ((226, 190, 60), (40, 36, 30)),
    ((246, 246, 244), (30, 90, 150)),
    ((238, 210, 70), (40, 110, 50)),
    ((236, 236, 234), (40, 60, 110)),
    ((40, 70, 120), (236, 236, 236)),
    ((234, 232, 226), (170, 40, 30)),
)


def window_pane(variant: int, rng: np.random.Generator) -> Picture:
    """A dark room behind glass: net curtains, drapes, plants, or nothing but gloom."""
    size = 192
    canvas = _room(rng, size, size, 26.0 + 22.0 * rng.random())
    if variant in (0, 1, 4):
        _net_curtain(canvas, rng, top=0.0, bottom=(1.0, 0.55, 1.0, 1.0, 0.35)[variant])
    if variant in (1, 2, 5):
        shade = rng.uniform(120, 180) * rng.uniform(0.9, 1.05, 3) * (1.0, 0.94, 0.84)
        for left in (True, False):
            _drape(canvas, rng, shade, 0.24 if variant != 5 else 0.4, left=left)
    if variant in (2, 3):
        _plants(canvas, rng)
    if variant == 6:
        canvas[:] = canvas * 0.7 + _sky_gradient(size, size) * 0.5
    if variant == 7:
        canvas *= 0.5
    return picture(canvas)


def shop_window(variant: int, rng: np.random.Generator) -> Picture:
    """Displays, lamps and posters in front of a dim shop; the last two are empty halls."""
    height, width = 288, 384
    canvas = _room(rng, height, width, 36.0)
    if variant < 3:
        _display(canvas, rng)
    else:
        _hall(canvas, rng)
    return picture(canvas + 5.0 * white_noise(rng, height, width, 1.0)[..., None])


def door(variant: int, rng: np.random.Generator) -> Picture:
    """Panelled wood, wood with glass, white with glass, green boards, steel, all glass."""
    height, width = 320, 160
    colour = (
        (92, 56, 34),
        (112, 70, 40),
        (214, 214, 210),
        (48, 72, 56),
        (150, 154, 156),
        (150, 152, 154),
    )[variant]
    grain = fractal_noise(rng, height, width, cells=10, octaves=5)
    canvas = coloured(colour, 0.05 * grain * (variant in (0, 1, 3)) + 0.015 * grain, 1.0)
    if variant in (0, 1):
        for y0, y1 in ((20, 130), (150, 300)):
            for x0, x1 in ((16, 74), (86, 144)):
                _panel(canvas, x0, x1, y0, y1)
    if variant == 1:
        _glass(canvas, rng, 24, 136, 24, 126)
    if variant == 2:
        _glass(canvas, rng, 26, 134, 24, 150)
        _glass(canvas, rng, 26, 134, 172, 296)
    if variant == 3:
        canvas[:, ::20] *= 0.55
    if variant == 4:
        _panel(canvas, 6, 154, 6, 314)
    if variant == 5:
        _glass(canvas, rng, 12, 148, 12, 306)
        canvas[60:220, 18:24] = 190.0
    cv2.rectangle(canvas, (138, 168), (150, 178), (196.0, 194.0, 186.0), -1)
    canvas[:, :3] *= 0.6
    canvas[:, -3:] *= 0.6
    canvas[-14:] *= 0.7
    return picture(canvas)


def garage_door(variant: int, rng: np.random.Generator) -> Picture:
    """Up-and-over door, near white: upright ribs, level ribs, panels, boards."""
    size = 256
    stain = fractal_noise(rng, size, size, cells=5, octaves=6, persistence=0.6)
    canvas = coloured((226, 226, 224), 0.02 * stain, 1.0)
    step = np.arange(size) % (11, 13, 64, 21)[variant]
    rib = np.where(step < 2, 0.62, np.where(step < 4, 1.05, 1.0)).astype(np.float32)
    if variant in (0, 2, 3):
        canvas *= rib[None, :, None]
    if variant in (1, 2):
        canvas *= rib[:, None, None]
    up = np.linspace(0, 1, size, dtype=np.float32)[:, None, None]
    canvas *= 1.0 - 0.25 * np.clip((up - 0.8) * 5 + 0.15 * stain[..., None], 0, 1) * (up > 0.6)
    cv2.rectangle(canvas, (0, 0), (size - 1, size - 1), (150.0, 150.0, 148.0), 5)
    cv2.rectangle(canvas, (122, 150), (134, 156), (40.0, 40.0, 42.0), -1)
    return picture(canvas)


def shutter(_: int, rng: np.random.Generator) -> Picture:
    """Slats of 5 cm, near white; 1 m x 1 m."""
    size = 160
    step = (np.arange(size) % 8).astype(np.float32)
    shade = np.where(step == 0, -0.45, -0.05 + 0.02 * step)
    return picture(
        coloured((228, 228, 226), shade[:, None] + 0.015 * white_noise(rng, size, size), 1.0)
    )


def awning(variant: int, rng: np.random.Generator) -> Picture:
    """Cloth, plain or with stripes of 0.2 m, near white; 1.6 m x 1.6 m."""
    size = 256
    stripe = np.where((np.arange(size) // 32) % 2, 0.0, -0.55 * variant).astype(np.float32)
    soft = 0.02 * fractal_noise(rng, size, size, cells=4)
    canvas = coloured((235, 235, 232), soft, 1.0)
    return picture(canvas * (1.0 + stripe)[None, :, None])


def shop_sign(variant: int, rng: np.random.Generator) -> Picture:
    """The name of a shop on one colour."""
    height, width = 64, 384
    ground, ink = _SIGN_COLOURS[variant]
    canvas = picture(coloured(ground, 0.01 * white_noise(rng, height, width), 1.0))
    font = (cv2.FONT_HERSHEY_DUPLEX, cv2.FONT_HERSHEY_TRIPLEX, cv2.FONT_HERSHEY_COMPLEX)[
        variant % 3
    ]
    name = _NAMES[variant]
    (long, tall), _ = cv2.getTextSize(name, font, 1.5, 3)
    where = ((width - long) // 2, (height + tall) // 2)
    cv2.putText(canvas, name, where, font, 1.5, ink, 3, cv2.LINE_AA)
    return canvas


def _room(rng: np.random.Generator, height: int, width: int, brightness: float) -> Canvas:
    """Gloom, a little lighter where a lamp or a far window is."""
    clouds = fractal_noise(rng, height, width, cells=3, octaves=3)
    return coloured(np.array([0.92, 1.0, 1.08]) * brightness, 0.25 * clouds, 1.0)


def _net_curtain(canvas: Canvas, rng: np.random.Generator, top: float, bottom: float) -> None:
    height, width = canvas.shape[:2]
    folds = fractal_noise(rng, 4, width, cells=14, octaves=3)[0]
    cloth = np.clip(148.0 + 26.0 * folds, 60, 215)[None, :, None] * np.array([1.0, 1.0, 0.97])
    hem = (0.006 * height * folds[None] + bottom * height).astype(int)
    rows = np.arange(height)[:, None]
    shown = 0.72 * ((rows >= top * height) & (rows < hem)).astype(np.float32)[..., None]
    canvas[:] = canvas * (1 - shown) + cloth * shown


def _drape(
    canvas: Canvas,
    rng: np.random.Generator,
    shade: NDArray[np.floating],
    share: float,
    *,
    left: bool,
) -> None:
    width = canvas.shape[1]
    reach = int(share * width)
    folds = fractal_noise(rng, 4, reach, cells=6, octaves=2)[0]
    cloth = np.clip(1.0 + 0.25 * folds, 0.4, 1.4)[None, :, None] * np.asarray(shade, np.float32)
    part = slice(0, reach) if left else slice(width - reach, width)
    canvas[:, part] = cloth


def _plants(canvas: Canvas, rng: np.random.Generator) -> None:
    height, width = canvas.shape[:2]
    for x in rng.uniform(0.1, 0.9, 4) * width:
        spread = height * rng.uniform(0.08, 0.2)
        for dx, dy in rng.normal(0.0, 0.5, (14, 2)) * spread:
            green = (np.array([46, 84, 40]) * rng.uniform(0.5, 1.3)).tolist()
            centre = (int(x + dx), int(height - spread - 8 + dy))
            cv2.ellipse(canvas, centre, (9, 4), rng.uniform(0, 180), 0, 360, green, -1, cv2.LINE_AA)
        pot = (np.array([120, 70, 48]) * rng.uniform(0.6, 1.2)).tolist()
        cv2.rectangle(canvas, (int(x) - 8, height - 18), (int(x) + 8, height), pot, -1)


def _sky_gradient(height: int, width: int) -> Canvas:
    """Reflected sky above, reflected houses below."""
    up = np.linspace(1.0, 0.0, height, dtype=np.float32)[:, None, None]
    return np.broadcast_to(40.0 + up * np.array([80, 110, 150]), (height, width, 3)).astype(
        np.float32
    )


def _display(canvas: Canvas, rng: np.random.Generator) -> None:
    """Goods on steps and shelves, spots under the ceiling, a poster on the glass."""
    height, width = canvas.shape[:2]
    ground = rng.uniform(70, 150) * np.array([1.0, 0.95, 0.86])
    canvas[int(0.86 * height) :] = ground
    for level in (0.42, 0.62, 0.86):
        base, x = int(level * height), int(rng.integers(4, 30))
        cv2.rectangle(canvas, (0, base), (width, base + 3), (0.6 * ground).tolist(), -1)
        while x < width - 12:
            wide, tall = int(rng.integers(8, 30)), int(rng.uniform(0.04, 0.17) * height)
            colour = rng.uniform(25, 190) * rng.uniform(0.6, 1.0, 3)
            if rng.random() < 0.75:
                cv2.rectangle(canvas, (x, base - tall), (x + wide, base), colour.tolist(), -1)
            x += wide + int(rng.integers(2, 40))
    canvas[:] = cv2.GaussianBlur(canvas, (0, 0), 1.3)
    for x in range(30, width, 62):
        cv2.circle(canvas, (x, 14), 4, (250.0, 240.0, 210.0), -1, cv2.LINE_AA)
    x, y = int(rng.integers(20, width - 110)), int(rng.integers(60, 110))
    paper, print_ = rng.uniform(170, 235) * np.ones(3), rng.uniform(20, 190, 3)
    cv2.rectangle(canvas, (x, y), (x + 60, y + 82), paper.tolist(), -1)
    cv2.rectangle(canvas, (x + 7, y + 9), (x + 53, y + 46), print_.tolist(), -1)


def _hall(canvas: Canvas, rng: np.random.Generator) -> None:
    """The far side of a glass hall: its own windows, columns, a dark floor."""
    height, width = canvas.shape[:2]
    floor = int(0.8 * height)
    for x in np.linspace(0.1, 0.9, 5) * width:
        light = (rng.uniform(60, 130) * np.array([0.9, 1.0, 0.95])).tolist()
        cv2.rectangle(
            canvas, (int(x) - 22, int(0.35 * height)), (int(x) + 22, int(0.72 * height)), light, -1
        )
    canvas[:] = cv2.GaussianBlur(canvas, (0, 0), 3.0)
    canvas[floor:] *= 0.6
    for x in (0.22, 0.7):
        canvas[:, int(x * width) : int(x * width) + 9] = 20.0


def _glass(canvas: Canvas, rng: np.random.Generator, x0: int, x1: int, y0: int, y1: int) -> None:
    """Structured glass with a dark rim."""
    pane = coloured((92, 100, 100), 0.15 * white_noise(rng, y1 - y0, x1 - x0, 2.0), 1.0)
    canvas[y0 - 3 : y1 + 3, x0 - 3 : x1 + 3] *= 0.55
    canvas[y0:y1, x0:x1] = pane


def _panel(canvas: Canvas, x0: int, x1: int, y0: int, y1: int) -> None:
    """A sunken field: shadow above and left, light below and right."""
    canvas[y0 : y0 + 4, x0:x1] *= 0.55
    canvas[y0:y1, x0 : x0 + 4] *= 0.6
    canvas[y1 - 3 : y1, x0:x1] *= 1.3
    canvas[y0:y1, x1 - 3 : x1] *= 1.25
