"""The overlay: everything that is painted on a road, spilt on it, or worn into it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.kernels import kernel
from avsec_gym.world.road.canvas import RoadCanvas
from avsec_gym.world.road.covers import paint_covers
from avsec_gym.world.road.junction import mouths
from avsec_gym.world.road.markings import paint_markings
from avsec_gym.world.road.paving import paint_paving
from avsec_gym.world.road.repairs import paint_repairs
from avsec_gym.world.road.surface import painted_edges
from avsec_gym.world.road.wear import paint_leaves, paint_ragged_edges, paint_stains, paint_tracks
from avsec_gym.world.site import Site

_FINEST = 0.025
"""Metres per pixel."""
_MEMORY = 60e6
"""Bytes of the picture with its coarser levels, at most."""
_EVEN = 32
_GAMMA = 2.2


@dataclass(frozen=True, eq=False)
class Overlay:
    """A picture over the road: columns run along it, rows from its left side to its right.

    The middle of pixel (row, column) lies at road coordinates
    ``along = start + (column + 0.5) * metres_per_pixel`` and
    ``left = top - (row + 0.5) * metres_per_pixel``.  `Mesh.overlay_uv` counts metres from the
    picture's upper left corner, ``(along - start, top - left)``, so that
    ``overlay_uv / metres_per_pixel`` are columns and rows.  A surface shows
    ``mix(surface, picture.rgb, picture.alpha)``; beyond the picture's edges it shows itself.

    Args:
        picture: Pixels as red, green, blue (sRGB, not multiplied by alpha) and alpha, uint8, shape
            (h, w, 4).
        start: Road coordinate `along` of the left edge, metres.
        top: Road coordinate `left` of the upper edge, metres.
        metres_per_pixel: Size of a pixel in both directions, metres.
    """

    picture: NDArray[np.uint8]
    start: float
    top: float
    metres_per_pixel: float

    def levels(self) -> list[NDArray[np.uint8]]:
        """The picture for sampling, and its halves, down to a few pixels.

        Returns:
            Pictures of shape (h, w, 4): red, green and blue in linear light, multiplied by alpha
            and then encoded like sRGB (``255 * (alpha * light) ** (1 / 2.2)``), and alpha.  A
            level has half as many (rounded up) rows and columns as the last, each the mean of
            four pixels in linear light, so that ``surface * (1 - alpha) + light`` is right at
            every level.
        """
        levels = [_multiplied(self.picture, *_tables())]
        while max(levels[-1].shape[:2]) > 4:
            levels.append(_halved(levels[-1], *_tables()[:2]))
        return levels


def paint_overlay(site: Site, start: float, end: float, rng: np.random.Generator) -> Overlay:
    """Markings, wear, repairs, covers, stains and leaves of the main road.

    Args:
        site: The place.
        start: Road coordinate of the beginning, as given to
            `avsec_gym.world.road.surface.road_meshes`.
        end: Road coordinate of the end, as given to the same.
        rng: The source of chance.

    Returns:
        2.5 cm per pixel, coarser where that takes more than 60 MB.
    """
    right, left = painted_edges(site.section)
    area = (end - start) * (left - right)
    metres = max(_FINEST, float(np.sqrt(area * 4 * 4 / 3 / _MEMORY)))
    # Sides that halve without a rest for some levels.
    size = _EVEN * np.ceil(np.array([left - right, end - start]) / metres / _EVEN).astype(int)
    canvas = RoadCanvas(np.zeros((*size, 4), np.uint8), start, left, 1.0 / metres)
    openings = mouths(site, start, end)
    paint_tracks(canvas, site, openings, rng)
    paint_paving(canvas, site, openings, rng)
    paint_repairs(canvas, site, rng)
    paint_ragged_edges(canvas, site, openings, rng)
    paint_stains(canvas, site, rng)
    paint_covers(canvas, site, openings, rng)
    paint_markings(canvas, site, openings, rng)
    paint_leaves(canvas, site, openings, rng)
    return Overlay(canvas.picture, start, left, metres)


def _tables() -> tuple[NDArray[np.float32], NDArray[np.uint8]]:
    """Light of 256 values, and the values of 65536 steps of light."""
    light = (np.arange(256) / 255.0) ** _GAMMA
    codes = 255.0 * (np.arange(65536) / 65535.0) ** (1.0 / _GAMMA)
    return light.astype(np.float32), np.round(codes).astype(np.uint8)


@kernel()
def _multiplied(picture, light, codes):  # type: ignore[no-untyped-def]
    """The picture, its linear light multiplied by alpha and encoded again; 0 where alpha is 0."""
    height, width = picture.shape[:2]
    result = np.zeros_like(picture)
    for i in range(height):
        for j in range(width):
            alpha = picture[i, j, 3]
            if alpha:
                share = np.float32(65535.0 / 255.0) * alpha
                for k in range(3):
                    code = int(share * light[picture[i, j, k]] + np.float32(0.5))
                    result[i, j, k] = codes[min(code, 65535)]
                result[i, j, 3] = alpha
    return result


@kernel()
def _halved(level, light, codes):  # type: ignore[no-untyped-def]
    """Half of the size, rounded up: means of two by two pixels, in linear light.

    Invariant: colours are multiplied by alpha already, so that plain means are right; the last row
    and column of an odd size count twice.
    """
    height, width = level.shape[:2]
    rows, columns = (height + 1) // 2, (width + 1) // 2
    result = np.empty((rows, columns, 4), np.uint8)
    for i in range(rows):
        upper, lower = 2 * i, min(2 * i + 1, height - 1)
        for j in range(columns):
            left, right = 2 * j, min(2 * j + 1, width - 1)
            for k in range(3):
                total = (
                    light[level[upper, left, k]]
                    + light[level[upper, right, k]]
                    + light[level[lower, left, k]]
                    + light[level[lower, right, k]]
                )
                result[i, j, k] = codes[int(total * np.float32(65535.0 / 4.0) + np.float32(0.5))]
            total_alpha = (
                np.int64(level[upper, left, 3])
                + level[upper, right, 3]
                + level[lower, left, 3]
                + level[lower, right, 3]
            )
            result[i, j, 3] = (total_alpha + 2) // 4
    return result
