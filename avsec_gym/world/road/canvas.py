"""A picture in road coordinates that is painted on in layers."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel
from avsec_gym.world.textures.noise import fractal_noise, white_noise

Mask = NDArray[np.uint8]
"""Opacity, 0..255, shape (h, w)."""
Colour = tuple[float, float, float]
"""Red, green, blue, 0..255."""

_FRACTION = 4
"""Bits behind the point of cv2's coordinates."""
_TILE = 512


@dataclass(frozen=True, eq=False)
class RoadCanvas:
    """What is painted so far; painting changes `picture` in place.

    Args:
        picture: Pixels as red, green, blue (not multiplied by alpha), alpha, shape (h, w, 4).
        start: Road coordinate `along` of its left edge, metres.
        top: Road coordinate `left` of its upper edge, metres.
        scale: Resolution, pixels per metre.
    """

    picture: NDArray[np.uint8]
    start: float
    top: float
    scale: float

    @property
    def end(self) -> float:
        """Road coordinate of the right edge."""
        return self.start + self.picture.shape[1] / self.scale

    def pixels(self, along: ArrayLike, left: ArrayLike) -> Floats:
        """Columns and rows of places, counted from the corner, shape (..., 2)."""
        x = (np.asarray(along, float) - self.start) * self.scale
        y = (self.top - np.asarray(left, float)) * self.scale
        return np.stack(np.broadcast_arrays(x, y), axis=-1)

    def fill(
        self,
        polygons: Sequence[ArrayLike],
        colour: Colour,
        opacity: float = 1.0,
        *,
        wear: tuple[NDArray[np.uint8], tuple[int, int]] | None = None,
        grain: tuple[int, int] | None = None,
    ) -> None:
        """Fill polygons that do not overlap.

        Args:
            polygons: Corners in road coordinates, each of shape (n, 2).
            colour: Colour of the whole area.
            opacity: Opacity in [0, 1].
            wear: Repeating picture by which the opacity is multiplied, and its offset.
            grain: Offset at which the grain begins; the colour varies like asphalt.
        """
        corners = [self.pixels(*np.asarray(polygon, float).T) for polygon in polygons]
        window = self._window(corners, 1.0)
        if window is None:
            return
        x, y, mask = window
        cv2.fillPoly(mask, _fixed(corners, x, y), 255, cv2.LINE_AA, _FRACTION)
        self.lay(mask, x, y, colour, opacity, wear=wear, grain=grain)

    def stroke(
        self,
        lines: Iterable[ArrayLike],
        width: float,
        colour: Colour,
        opacity: float = 1.0,
        *,
        closed: bool = False,
        wear: tuple[NDArray[np.uint8], tuple[int, int]] | None = None,
    ) -> None:
        """Draw lines of a width in metres (a pixel at least) through places, shape (n, 2)."""
        corners = [self.pixels(*np.asarray(line, float).T) for line in lines]
        thickness = max(1, round(width * self.scale))
        window = self._window(corners, thickness + 1.0)
        if window is None:
            return
        x, y, mask = window
        cv2.polylines(mask, _fixed(corners, x, y), closed, 255, thickness, cv2.LINE_AA, _FRACTION)
        self.lay(mask, x, y, colour, opacity, wear=wear)

    def lay(
        self,
        mask: Mask,
        x: int,
        y: int,
        colour: Colour,
        opacity: float = 1.0,
        *,
        wear: tuple[NDArray[np.uint8], tuple[int, int]] | None = None,
        grain: tuple[int, int] | None = None,
    ) -> None:
        """Lay a colour over what is there, as opaque as a mask states.

        Args:
            mask: Cut off where it goes beyond the picture.
            x: Column of its left edge.
            y: Row of its upper edge.
            colour: Colour of all of it.
            opacity: Opacity of the mask's 255.
            wear: Tile of wear and its offset, see `fill`.
            grain: Offset at which the grain begins, see `fill`.
        """
        height, width = self.picture.shape[:2]
        first, upper = max(0, -x), max(0, -y)
        part = mask[upper : height - y, first : width - x]
        if part.size == 0:
            return
        worn, worn_at = wear or (_even_tile(), (0, 0))
        grained, grain_at = (grain_tile(), grain) if grain else (_even_tile(), (0, 0))
        _lay_over(
            self.picture,
            np.ascontiguousarray(part),
            y + upper,
            x + first,
            np.array(colour, np.float32),
            np.float32(opacity / 255.0),
            worn,
            worn_at,
            grained,
            grain_at,
        )

    def _window(self, corners: Sequence[Floats], margin: float) -> tuple[int, int, Mask] | None:
        """An empty mask around places, cut off at the picture's edges."""
        if not corners:
            return None
        every = np.concatenate(corners)
        low = np.floor(every.min(axis=0) - margin).astype(int)
        high = np.ceil(every.max(axis=0) + margin).astype(int)
        height, width = self.picture.shape[:2]
        low, high = np.maximum(low, 0), np.minimum(high, [width, height])
        if (low >= high).any():
            return None
        size = high - low
        return int(low[0]), int(low[1]), np.zeros((size[1], size[0]), np.uint8)


def rectangle(first: float, last: float, right: float, left: float) -> Floats:
    """Corners of a rectangle in road coordinates, shape (4, 2)."""
    return np.array([(first, right), (last, right), (last, left), (first, left)])


def offset(rng: np.random.Generator) -> tuple[int, int]:
    """Somewhere on a repeating picture."""
    row, column = rng.integers(0, _TILE, 2)
    return int(row), int(column)


@functools.cache
def grain_tile() -> NDArray[np.uint8]:
    """Grain of asphalt: brightness, 128 for the mean; repeats."""
    rng = np.random.default_rng(71)
    noise = white_noise(rng, _TILE, _TILE, 0.4) + 0.35 * white_noise(rng, _TILE, _TILE, 1.5)
    return np.clip(128.0 + 13.0 * noise, 0, 255).astype(np.uint8)


@functools.cache
def wear_tile(wear: int) -> NDArray[np.uint8]:
    """How much of paint is left, 0..255; `wear` 0 (fresh) to 4 (hardly any left); repeats."""
    rng = np.random.default_rng((72, wear))
    patches = fractal_noise(rng, _TILE, _TILE, cells=12, octaves=6, persistence=0.75)
    fine = white_noise(rng, _TILE, _TILE, 0.6)
    left = 1.25 - 0.22 * wear + (0.07 + 0.06 * wear) * (patches + 0.6 * fine)
    return np.clip(255.0 * left, 12, 250).astype(np.uint8)


@functools.cache
def _even_tile() -> NDArray[np.uint8]:
    return np.full((1, 1), 255, np.uint8)


def _fixed(corners: Sequence[Floats], x: int, y: int) -> list[NDArray[np.int32]]:
    """Whole numbers of sixteenths; cv2 counts from pixels' centres."""
    return [
        np.round((each - [x + 0.5, y + 0.5]) * 2**_FRACTION).astype(np.int32) for each in corners
    ]


@kernel()
def _lay_over(picture, mask, top, left, colour, opacity, wear, wear_at, grain, grain_at):  # type: ignore[no-untyped-def]
    """Lay a colour over a part of a picture, in place; see `RoadCanvas.lay`.

    Invariant: pixels keep their colour apart from their alpha; what is fully transparent below has
    no share in the mixture.
    """
    rows, columns = mask.shape
    grained = grain.shape[0] > 1
    for i in range(rows):
        wear_row = (i + wear_at[0]) % wear.shape[0]
        grain_row = (i + grain_at[0]) % grain.shape[0]
        for j in range(columns):
            if mask[i, j] == 0:
                continue
            alpha = np.float32(mask[i, j]) * opacity
            alpha *= wear[wear_row, (j + wear_at[1]) % wear.shape[1]] * np.float32(1.0 / 255.0)
            shade = np.float32(1.0)
            if grained:
                shade = grain[grain_row, (j + grain_at[1]) % grain.shape[1]] * np.float32(1 / 128.0)
            pixel = picture[top + i, left + j]
            under = pixel[3] * np.float32(1.0 / 255.0) * (np.float32(1.0) - alpha)
            total = alpha + under
            if total <= np.float32(0.0):
                continue
            share = alpha / total
            for k in range(3):
                value = colour[k] * shade * share + pixel[k] * (np.float32(1.0) - share)
                pixel[k] = np.uint8(min(value + np.float32(0.5), np.float32(255.0)))
            pixel[3] = np.uint8(min(total * np.float32(255.0) + np.float32(0.5), np.float32(255.0)))
