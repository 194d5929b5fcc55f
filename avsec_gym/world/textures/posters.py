"""Posters, flags and scribbles: what people stick and spray on street furniture."""

from __future__ import annotations

import cv2
import numpy as np

from avsec_gym.world.textures.drawing import (
    Canvas,
    Colour,
    canvas,
    disc,
    fill,
    finished,
    letters,
    rectangle,
    stroke,
)
from avsec_gym.world.textures.noise import fractal_noise, picture
from avsec_gym.world.textures.texture import Picture, Texture

_WORDS = (
    "SOMMER",
    "MESSE",
    "KONZERT",
    "ZIRKUS",
    "THEATER",
    "MARKT",
    "FEST",
    "KINO",
    "MUSEUM",
    "NEU",
)
_LINES = ("ab 3. Oktober", "Karlsruhe", "Stadthalle", "jeden Freitag", "am Schlossplatz", "20 Uhr")
_COLOURS: tuple[Colour, ...] = (
    (176, 44, 42),
    (208, 168, 58),
    (40, 84, 140),
    (206, 206, 200),
    (44, 112, 84),
    (196, 100, 44),
    (34, 36, 42),
    (104, 46, 102),
    (136, 172, 190),
    (196, 138, 142),
)
"""Printing inks after some weeks of sun."""
_POSTER = (1.2, 1.7)
"""Width and height, metres."""
_WIDE_POSTER = (3.6, 2.5)


def poster(_: int, rng: np.random.Generator) -> Picture:
    """An advertisement: a ground, a big motif, a word and small print."""
    on = _empty(rng)
    ground, motif, ink = (_COLOURS[i] for i in rng.permutation(len(_COLOURS))[:3])
    rectangle(on, (-0.57, -0.82), (0.57, 0.82), ground)
    _motif(on, rng, motif, ink)
    dark = sum(ground) < 380
    text: Colour = (212, 212, 206) if dark else (20, 20, 24)
    top = float(rng.choice([0.62, -0.34]))
    letters(on, str(rng.choice(_WORDS)), (0, top), 0.22, text, widest=1.0, weight=0.2)
    letters(on, str(rng.choice(_LINES)), (0, top - 0.22), 0.09, text, widest=0.9)
    for line in range(3):
        reach = float(rng.uniform(0.2, 0.48))
        y = -0.68 - 0.04 * line
        rectangle(on, (-reach, y), (reach, y + 0.018), text)
    return finished(on, rng, 0.05)


def wide_poster(_: int, rng: np.random.Generator) -> Picture:
    """A poster of 3.6 m by 2.5 m: the motif at the left, words at the right."""
    on = canvas(*_WIDE_POSTER, (214, 213, 206), 90)
    ground, motif, ink = (_COLOURS[i] for i in rng.permutation(len(_COLOURS))[:3])
    rectangle(on, (-1.75, -1.2), (1.75, 1.2), ground)
    _motif(Canvas(on.pixels[:, : on.pixels.shape[1] // 2], on.metre * 1.45), rng, motif, ink)
    text: Colour = (212, 212, 206) if sum(ground) < 380 else (20, 20, 24)
    letters(on, str(rng.choice(_WORDS)), (0.85, 0.45), 0.42, text, widest=1.6, weight=0.2)
    letters(on, str(rng.choice(_LINES)), (0.85, -0.1), 0.2, text, widest=1.5)
    letters(on, str(rng.choice(_LINES)), (0.85, -0.5), 0.2, text, widest=1.5)
    rectangle(on, (0.2, -1.0), (1.5, -0.9), text)
    return finished(on, rng, 0.05)


def pasted(_: int, rng: np.random.Generator) -> Picture:
    """The skin of an advertising pillar, 4.4 m round and 2.8 m high: posters side by side."""
    density = 80
    wall = np.full((int(2.8 * density), int(4.4 * density), 3), (196, 194, 186), np.float32)
    wall *= 1.0 + 0.08 * fractal_noise(rng, *wall.shape[:2])[..., None]
    for left in np.arange(0.0, 4.4 - 0.3, 1.1):
        top = 0.05
        while top < 2.2:
            tall = float(rng.choice([0.85, 1.2, 1.45]))
            wide = float(rng.uniform(0.75, 1.05))
            rows = slice(int(top * density), int(min(top + tall, 2.75) * density))
            columns = slice(int((left + 0.02) * density), int((left + wide) * density))
            target = wall[rows, columns]
            sheet = poster(0, rng)
            target[:] = cv2.resize(sheet, target.shape[1::-1], interpolation=cv2.INTER_AREA)
            top += tall + 0.04
    return picture(wall)


def flag(variant: int, rng: np.random.Generator) -> Picture:
    """A flag hung by its short side, 1.2 m wide and 3 m high."""
    stripes: tuple[tuple[Colour, ...], ...] = (
        ((24, 24, 26), (206, 30, 36), (248, 204, 30)),
        ((248, 204, 30), (200, 30, 40), (248, 204, 30)),
        ((24, 24, 26), (248, 208, 40)),
        ((236, 238, 240), (20, 90, 170), (236, 238, 240)),
    )
    colours = stripes[variant]
    on = canvas(1.2, 3.0, (255, 255, 255), 60)
    for index, colour in enumerate(colours):
        left = -0.6 + 1.2 * index / len(colours)
        rectangle(on, (left, -1.5), (left + 1.2 / len(colours), 1.5), colour)
    return finished(on, rng, 0.02)


def scribbled(variant: int, rng: np.random.Generator) -> Picture:
    """Paint that weathered, 2 m by 2 m, with stickers and sprayed scrawls on all but the first."""
    on = canvas(2.0, 2.0, (214, 214, 210), 128)
    for _ in range(3 * variant):
        colour = _COLOURS[rng.integers(len(_COLOURS))]
        # A tag: a hand that hurries through a few places.
        places = rng.uniform((-0.06, -0.14), (0.06, 0.14), (9, 2))
        places[:, 0] += np.linspace(0.0, rng.uniform(0.2, 0.5), 9)
        at = np.linspace(0.0, 8.0, 65)
        line = np.stack([np.interp(at, np.arange(9), column) for column in places.T], axis=1)
        line = cv2.GaussianBlur(line, (1, 9), 0) + rng.uniform(-0.8, 0.5, 2)
        stroke(on, line, float(rng.uniform(0.012, 0.03)), colour)
    for _ in range(5 * variant):
        x, y = rng.uniform(-0.9, 0.9, 2).tolist()
        w, h = rng.uniform(0.03, 0.1, 2).tolist()
        rectangle(on, (x, y), (x + w, y + h), _COLOURS[rng.integers(len(_COLOURS))])
    clean = finished(on, rng, 0.0).astype(np.float32)
    # Rain leaves faint streaks, the road splashes from below.
    streaks = fractal_noise(rng, 256, 256, cells=48, octaves=3)[:1]
    dirt = 1.0 + 0.02 * fractal_noise(rng, 256, 256, cells=4) - 0.03 * np.clip(streaks, 0, None)
    return picture(clean * dirt[..., None])


def _empty(rng: np.random.Generator) -> Canvas:
    paper: Colour = (214, 213, 206) if rng.random() < 0.8 else (40, 42, 46)
    return canvas(*_POSTER, paper, 110)


def _motif(on: Canvas, rng: np.random.Generator, colour: Colour, ink: Colour) -> None:
    kind = rng.integers(5)
    if kind == 0:  # A sun behind hills.
        disc(on, (float(rng.uniform(-0.2, 0.2)), 0.2), 0.32, colour)
        x = np.linspace(-0.57, 0.57, 20)
        hills = np.stack([x, 0.05 + 0.12 * np.sin(6 * x + rng.uniform(0, 6))], axis=1)
        fill(on, [*hills, (0.57, -0.2), (-0.57, -0.2)], ink)
    elif kind == 1:  # A head and shoulders.
        disc(on, (0, 0.22), 0.2, (224, 172, 140))
        disc(on, (0, 0.31), 0.19, ink)
        disc(on, (0, 0.17), 0.15, (224, 172, 140))
        fill(on, [(-0.38, -0.25), (0.38, -0.25), (0.26, 0.0), (-0.26, 0.0)], colour)
    elif kind == 2:  # Slanting bands.
        for offset in np.arange(-0.5, 0.6, 0.36):
            band = np.array([(-0.57, -0.25), (0.57, 0.1), (0.57, 0.26), (-0.57, -0.09)])
            fill(on, np.clip(np.add(band, (0, offset)), -0.82, 0.82), colour if offset < 0 else ink)
    elif kind == 3:  # A photograph: blurred light and dark.
        low, high = on.place([(-0.5, 0.42), (0.5, -0.25)]).astype(int)
        size = (high - low)[::-1]
        shade = fractal_noise(rng, int(size[0]), int(size[1]), cells=5, octaves=4)
        mix = np.clip(0.5 + 0.4 * shade, 0, 1)[..., None]
        on.pixels[low[1] : high[1], low[0] : high[0]] = mix * colour + (1 - mix) * np.array(ink)
    else:  # Discs.
        for _ in range(6):
            x, y = rng.uniform(-0.35, 0.35, 2).tolist()
            disc(on, (x, y), float(rng.uniform(0.06, 0.2)), colour if rng.random() < 0.5 else ink)


POSTERS: dict[str, Texture] = {
    "poster": Texture(_POSTER, 10, poster),
    "wide_poster": Texture(_WIDE_POSTER, 5, wide_poster),
    "pillar_posters": Texture((4.4, 2.8), 3, pasted),
    "flag": Texture((1.2, 3.0), 4, flag),
    "scribbled": Texture((2.0, 2.0), 4, scribbled),
}
