"""`RangeImage`: the rays of one scan by direction, so that the ray next to any other is at hand."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.kernels import kernel
from avsec_gym.validation.connected.sweep import TIP

Ints = NDArray[np.int32]
Singles = NDArray[np.float32]

_COLUMNS, _ROWS = 1200, 300
"""Cells of 0.3 degrees, all around and from 45 degrees below to 45 degrees above the horizon."""
_CELL = 2.0 * np.pi / _COLUMNS
_LOWEST = -0.5 * _ROWS * _CELL
_NEAREST = 0.5
"""Metres within which a return comes from the sensor's own vehicle."""


class RangeImage(NamedTuple):
    """The rays of a scan, sorted into cells of 0.3 degrees (a tuple of arrays for kernels).

    Directions are those in the velodyne frame that each ray had when it was sent, as seen from
    where the rays leave (`TIP`): nothing is compensated.
    """

    start: Ints
    """Index of the first ray of each cell, row by row from below, shape (rows * columns + 1,)."""
    azimuth: Singles
    """Radians to the left of ahead, shape (M,)."""
    elevation: Singles
    """Radians above the horizon, shape (M,)."""
    distance: Singles
    """How far each ray came, metres, shape (M,)."""
    end: Singles
    """Where each ray ended, in the velodyne frame when it was sent, metres, shape (M, 3)."""
    lowest: float
    """The lowest elevation at which the sensor has rays, radians."""
    highest: float
    """The highest, radians."""


def range_image(points: NDArray[np.float32]) -> RangeImage:
    """Sort the rays of a scan by direction.

    Args:
        points: Points, each in the velodyne frame of its own pulse, shape (M, 3) or more columns;
            those that are not finite, or nearer than half a metre, are left out.
    """
    count = len(points)
    azimuth, elevation, distance = np.empty((3, count), np.float32)
    cell, start = np.empty(count, np.int32), np.zeros(_COLUMNS * _ROWS + 2, np.int32)
    _directions(points, azimuth, elevation, distance, cell, start)
    kept = int(start.sum())
    by_cell, end = np.empty((3, kept), np.float32), np.empty((kept, 3), np.float32)
    rows = start[2:].reshape(_ROWS, _COLUMNS).sum(axis=1)
    _sort(points, azimuth, elevation, distance, cell, start, by_cell, end)
    # Single stray returns do not make a field of view.
    used = np.flatnonzero(rows > 5)
    low, high = (used[0], used[-1] + 1) if len(used) else (0, 0)
    return RangeImage(
        start[:-1],
        by_cell[0],
        by_cell[1],
        by_cell[2],
        end,
        lowest=_LOWEST + low * _CELL,
        highest=_LOWEST + high * _CELL,
    )


def cells_between(image: RangeImage, first: float, last: float) -> NDArray[np.int64]:
    """The cells of all elevations between two azimuths, as runs of cells that lie in a row.

    Args:
        image: The rays.
        first: Azimuth of the right border, radians.
        last: Azimuth of the left border, the greater number.

    Returns:
        First cell and that after the last of each run, shape (R, 2).
    """
    rows = np.arange(round((image.highest - image.lowest) / _CELL))
    rows += round((image.lowest - _LOWEST) / _CELL)
    begin = int(np.floor((first + np.pi) / _CELL))
    end = min(int(np.floor((last + np.pi) / _CELL)) + 1, begin + _COLUMNS)
    begin, end = begin % _COLUMNS, end - begin + begin % _COLUMNS
    spans = [(begin, min(end, _COLUMNS))] + ([(0, end - _COLUMNS)] if end > _COLUMNS else [])
    return np.concatenate([rows[:, None] * _COLUMNS + np.array([span]) for span in spans])


@kernel(nogil=True)
def cells_around(
    azimuth: float, elevation: float, across: float, up: float
) -> tuple[int, int, int, int]:
    """The cells of which some direction is near a direction: rows, then columns, both half-open.

    Columns may lie outside of the image: those of a full turn less or more are meant.

    Args:
        azimuth: Azimuth of the direction, radians.
        elevation: Elevation of the direction, radians.
        across: Largest angle across, radians (of the sphere, not of azimuths).
        up: Largest angle up or down, radians.
    """
    # Azimuths lie closer together the higher the direction.
    side = min(across / max(np.cos(elevation), 0.1), 0.5 * np.pi)
    return (
        max(int(np.floor((elevation - up - _LOWEST) / _CELL)), 0),
        min(int(np.floor((elevation + up - _LOWEST) / _CELL)) + 1, _ROWS),
        int(np.floor((azimuth - side + np.pi) / _CELL)),
        int(np.floor((azimuth + side + np.pi) / _CELL)) + 1,
    )


@kernel(nogil=True)
def run_of_rays(
    image: RangeImage, row: int, from_column: int, to_column: int, run: int
) -> tuple[int, int]:
    """The rays of neighbouring cells of a row lie in one run, or in two across the seam behind.

    Args:
        image: The rays.
        row: The row.
        from_column: First column, as of `cells_around`.
        to_column: Column after the last, at most a full turn on.
        run: 0 or 1.

    Returns:
        Index of the run's first ray, and that after its last.
    """
    begin = from_column % _COLUMNS
    end = begin + to_column - from_column
    if run == 0:
        end = min(end, _COLUMNS)
    else:
        begin, end = 0, max(end - _COLUMNS, 0)
    return image.start[row * _COLUMNS + begin], image.start[row * _COLUMNS + end]


@kernel(nogil=True)
def angles_between(
    image: RangeImage, ray: int, azimuth: float, elevation: float
) -> tuple[float, float]:
    """By how much a ray points to the left of a direction and above it, radians."""
    left = image.azimuth[ray] - azimuth
    left -= 2.0 * np.pi * np.round(left / (2.0 * np.pi))
    return left * np.cos(elevation), image.elevation[ray] - elevation


@kernel(nogil=True)
def _directions(
    points: NDArray[np.float32],
    azimuth: Singles,
    elevation: Singles,
    distance: Singles,
    cell: Ints,
    start: Ints,
) -> None:
    """Polar coordinates and cells; `start` counts the rays of each cell, two places on."""
    for i in range(len(points)):
        x, y, z = points[i, 0], points[i, 1], points[i, 2] - np.float32(TIP)
        flat = x * x + y * y
        far = np.sqrt(flat + z * z)
        cell[i] = -1
        if not (_NEAREST < far < np.inf):
            continue
        azimuth[i] = np.arctan2(y, x)
        elevation[i] = np.arctan2(z, np.sqrt(flat))
        distance[i] = far
        column = int((azimuth[i] + np.pi) / _CELL) % _COLUMNS
        row = min(max(int(np.floor((elevation[i] - _LOWEST) / _CELL)), 0), _ROWS - 1)
        cell[i] = row * _COLUMNS + column
        start[cell[i] + 2] += 1


@kernel(nogil=True)
def _sort(
    points: NDArray[np.float32],
    azimuth: Singles,
    elevation: Singles,
    distance: Singles,
    cell: Ints,
    start: Ints,
    by_cell: Singles,
    end: Singles,
) -> None:
    """Counting sort: while it fills cell c, ``start[c + 1]`` moves from its begin to its end."""
    for c in range(1, len(start)):
        start[c] += start[c - 1]
    for i in range(len(cell)):
        if cell[i] >= 0:
            place = start[cell[i] + 1]
            start[cell[i] + 1] += 1
            by_cell[0, place] = azimuth[i]
            by_cell[1, place] = elevation[i]
            by_cell[2, place] = distance[i]
            for axis in range(3):
                end[place, axis] = points[i, axis]
