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


_ARCTANGENT = (
    0.001057607438057242,
    -0.007030669470424213,
    0.021912945865448393,
    -0.04392841073326746,
    0.06685281517877424,
    -0.08785043282362845,
    0.1105077127584966,
    -0.14278576024807985,
    0.19999558100363982,
    -0.33333322488911593,
    0.9999999995535376,
)
"""Coefficients of the polynomial in t^2 that meets arctan(t)/t in the 11 Chebyshev points of t^2
from 0 to 1."""


class RangeImage(NamedTuple):
    """The rays of a scan, sorted into cells of 0.3 degrees (a tuple of arrays for kernels).

    Directions are those in the velodyne frame that each ray had when it was sent, as seen from
    where the rays leave (`TIP`).
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
    """Where each ray ended, in the velodyne frame of the scan's time, metres, shape (M, 3)."""
    lowest: float
    """The lowest elevation at which the sensor has rays, radians."""
    highest: float
    """The highest, radians."""


def range_image(points: NDArray[np.float32], ends: NDArray[np.float32]) -> RangeImage:
    """Sort the rays of a scan by direction.

    Args:
        points: Points, each in the velodyne frame of its own pulse, shape (M, 3) or more columns;
            those that are not finite, or nearer than half a metre, are left out.
        ends: The same points in the velodyne frame of the scan's time, shape (M, 3) or more.
    """
    # Columns that lie in a row: only those does the compiler take several of at a time.
    x, y, z = np.ascontiguousarray(points[:, :3].T)
    azimuth, elevation, distance = np.empty((3, len(points)), np.float32)
    cell, start = np.empty(len(points), np.int32), np.zeros(_COLUMNS * _ROWS + 2, np.int32)
    _directions(x, y, z, azimuth, elevation, distance, cell)
    kept = _begin_cells(cell, start)
    by_cell, end = np.empty((3, kept), np.float32), np.empty((kept, 3), np.float32)
    _sort(azimuth, elevation, distance, ends, cell, start, by_cell, end)
    # Single stray returns do not make a field of view.
    used = np.flatnonzero(np.diff(start[:-1:_COLUMNS]) > 5)
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


@kernel(nogil=True)
def rows_of_view(image: RangeImage) -> tuple[int, int]:
    """The rows in which the sensor has rays: the first, and that after the last."""
    lowest, highest = image.lowest - _LOWEST, image.highest - _LOWEST
    return int(np.round(lowest / _CELL)), int(np.round(highest / _CELL))


@kernel(nogil=True)
def cells_between(
    right: float, left: float, lowest: float, highest: float
) -> tuple[int, int, int, int]:
    """The cells between two azimuths and two elevations: rows, then columns, both half-open.

    Columns may lie outside of the image: those of a full turn less or more are meant.

    Args:
        right: The lesser azimuth, radians.
        left: The greater azimuth, radians.
        lowest: The lesser elevation, radians.
        highest: The greater elevation, radians.
    """
    first = int(np.floor((right + np.pi) / _CELL))
    return (
        max(int(np.floor((lowest - _LOWEST) / _CELL)), 0),
        min(int(np.floor((highest - _LOWEST) / _CELL)) + 1, _ROWS),
        first,
        min(int(np.floor((left + np.pi) / _CELL)) + 1, first + _COLUMNS),
    )


@kernel(nogil=True)
def cells_around(
    azimuth: float, elevation: float, across: float, up: float
) -> tuple[int, int, int, int]:
    """The cells of which some direction is near a direction, as of `cells_between`.

    Args:
        azimuth: Azimuth of the direction, radians.
        elevation: Elevation of the direction, radians.
        across: Largest angle across, radians (of the sphere, not of azimuths).
        up: Largest angle up or down, radians.
    """
    # Azimuths lie closer together the higher the direction.
    side = min(across / max(np.cos(elevation), 0.1), 0.5 * np.pi)
    return cells_between(azimuth - side, azimuth + side, elevation - up, elevation + up)


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
    ray: tuple[float, float], azimuth: float, elevation: float
) -> tuple[float, float]:
    """The angles by which a ray points to the left of a direction and above it, radians.

    Args:
        ray: Azimuth and elevation of the ray, radians.
        azimuth: Azimuth of the direction, radians.
        elevation: Elevation of the direction, radians.
    """
    left = ray[0] - azimuth
    left -= 2.0 * np.pi * np.round(left / (2.0 * np.pi))
    return left * np.cos(elevation), ray[1] - elevation


@kernel(nogil=True)
def _directions(
    x: Singles,
    y: Singles,
    z: Singles,
    azimuth: Singles,
    elevation: Singles,
    distance: Singles,
    cell: Ints,
) -> None:
    """Polar coordinates and cells, -1 for a point that is no ray.

    A loop without branches and calls, of which the processor does several rays at a time.
    """
    for i in range(len(x)):
        up = z[i] - np.float32(TIP)
        flat = x[i] * x[i] + y[i] * y[i]
        far = np.sqrt(flat + up * up)
        left = np.float32(_angle(float(y[i]), float(x[i])))
        above = np.float32(_angle(float(up), float(np.sqrt(flat))))
        azimuth[i], elevation[i], distance[i] = left, above, far
        column = np.int32((left + np.pi) / _CELL)
        row = np.int32(min(max(float((above - _LOWEST) / _CELL), 0.0), _ROWS - 0.5))
        is_ray = (far > _NEAREST) & (far < np.inf)
        cell[i] = row * _COLUMNS + (column if column < _COLUMNS else 0) if is_ray else -1


@kernel(inline="always")
def _angle(y: float, x: float) -> float:
    """The angle from x to y, to a billionth: finer than the single precision that takes it."""
    long, short = max(abs(x), abs(y)), min(abs(x), abs(y))
    slope = short / max(long, 1e-30)
    square = slope * slope
    total = 0.0
    for coefficient in _ARCTANGENT:
        total = total * square + coefficient
    total *= slope
    total = 0.5 * np.pi - total if abs(y) > abs(x) else total
    total = np.pi - total if x < 0.0 else total
    return -total if y < 0.0 else total


@kernel(nogil=True)
def _begin_cells(cell: Ints, start: Ints) -> int:
    """Where each cell begins, one place on from where `RangeImage` has it; how many rays it is."""
    for i in range(len(cell)):
        # Points that are no rays are counted at place 1, and forgotten.
        start[cell[i] + 2] += 1
    start[1] = 0
    for c in range(2, len(start)):
        start[c] += start[c - 1]
    return start[-1]


@kernel(nogil=True)
def _sort(
    azimuth: Singles,
    elevation: Singles,
    distance: Singles,
    ends: Singles,
    cell: Ints,
    start: Ints,
    by_cell: Singles,
    end: Singles,
) -> None:
    """Counting sort: while it fills cell c, ``start[c + 1]`` moves from its begin to its end."""
    for i in range(len(cell)):
        if cell[i] >= 0:
            place = start[cell[i] + 1]
            start[cell[i] + 1] += 1
            by_cell[0, place] = azimuth[i]
            by_cell[1, place] = elevation[i]
            by_cell[2, place] = distance[i]
            for axis in range(3):
                end[place, axis] = ends[i, axis]
