"""Drawing with sharp edges and letters: the faces of signs and posters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from avsec_gym.world.textures.lettering import written
from avsec_gym.world.textures.noise import fractal_noise, picture
from avsec_gym.world.textures.texture import Picture

Colour = tuple[float, float, float]
"""Red, green, blue, 0..255 (sRGB)."""

_FINENESS = 4
"""Drawn so much larger and then averaged: smooth edges."""


@dataclass(frozen=True, eq=False)
class Canvas:
    """A picture in the making; places are metres from its centre, to the right and up.

    Args:
        pixels: Pixels, shape (h, w, 3); the functions below draw into it.
        metre: Length of a metre, pixels.
    """

    pixels: NDArray[np.float32]
    metre: float

    def place(self, points: ArrayLike) -> NDArray[np.float64]:
        """Where points are in pixels, shape (..., 2)."""
        height, width = self.pixels.shape[:2]
        scale = np.array([self.metre, -self.metre])
        return np.asarray(points, float) * scale + 0.5 * np.array([width, height])


def canvas(width: float, height: float, colour: Colour, density: float = 200) -> Canvas:
    """An empty picture of so many metres, `density` pixels a metre when finished."""
    size = (round(height * density) * _FINENESS, round(width * density) * _FINENESS)
    pixels = np.empty((*size, 3), np.float32)
    pixels[:] = colour
    return Canvas(pixels, density * _FINENESS)


def fill(on: Canvas, corners: ArrayLike, colour: Colour) -> None:
    """A polygon, shape (n, 2)."""
    cv2.fillPoly(on.pixels, [np.round(on.place(corners)).astype(np.int32)], colour)


def rectangle(on: Canvas, low: Sequence[float], high: Sequence[float], colour: Colour) -> None:
    """A rectangle between two corners, each x, y."""
    fill(on, [low, (high[0], low[1]), high, (low[0], high[1])], colour)


def disc(on: Canvas, centre: Sequence[float], radius: float, colour: Colour) -> None:
    """A filled circle."""
    middle = np.round(on.place(centre)).astype(int).tolist()
    cv2.circle(on.pixels, middle, round(radius * on.metre), colour, cv2.FILLED)


def stroke(on: Canvas, points: ArrayLike, width: float, colour: Colour) -> None:
    """A line with round ends through points, shape (n, 2)."""
    line = np.round(on.place(points)).astype(np.int32)
    cv2.polylines(on.pixels, [line], False, colour, max(1, round(width * on.metre)))


def arrow(
    on: Canvas, tail: Sequence[float], tip: Sequence[float], width: float, colour: Colour
) -> None:
    """A straight arrow with a shaft of `width` and a head of three times that."""
    start, end = np.array(tail, float), np.array(tip, float)
    ahead = (end - start) / np.linalg.norm(end - start)
    aside = 0.5 * width * np.array([-ahead[1], ahead[0]])
    neck = end - 2.4 * width * ahead
    corners = [start + aside, neck + aside, neck + 3.2 * aside, end]
    fill(on, [*corners, neck - 3.2 * aside, neck - aside, start - aside], colour)


def letters(
    on: Canvas,
    text: str,
    centre: Sequence[float],
    height: float,
    colour: Colour,
    *,
    widest: float = np.inf,
    weight: float = 0.16,
) -> None:
    """A line of text, its capitals centred at a place.

    Args:
        on: Canvas to draw on.
        text: Text of letters that `avsec_gym.world.textures.lettering` can write.
        centre: Centre of the text as x, y.
        height: Height of the capitals, metres.
        colour: Colour of the letters.
        widest: The text is narrowed to this width, metres.
        weight: Width of the strokes as a share of the height.
    """
    strokes, width = written(text)
    thick = weight * height
    tall = height - thick
    wide = min(tall, (widest - thick) / width) if width > 0 else tall
    for line in strokes:
        points = (line - [0.5 * width, 0.5]) * [wide, tall]
        stroke(on, points + np.asarray(centre, float), thick, colour)


def finished(on: Canvas, rng: np.random.Generator, wear: float = 0.03) -> Picture:
    """The picture, in its final size and a little uneven from sun and dirt."""
    height, width = (side // _FINENESS for side in on.pixels.shape[:2])
    fine = cv2.resize(on.pixels, (width, height), interpolation=cv2.INTER_AREA)
    return picture(fine * (1.0 + wear * fractal_noise(rng, height, width))[..., None])
