"""In which voxels of regions the rays of a scan end, as a kernel."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel
from avsec_gym.validation.connected.rays.range_image import (
    RangeImage,
    cells_between,
    rows_of_view,
    run_of_rays,
)
from avsec_gym.validation.connected.sweep import TIP, through, when_faced

VOXEL = 0.2
"""Edge of the voxels, metres."""
_ROUNDING = 0.01
"""Metres by which places may differ that are computed in single precision."""


@kernel(nogil=True)
def voxels_in_boxes(
    image: RangeImage,
    pose: Floats,
    to_sensor: Floats,
    motion: tuple[float, float, float],
    age: float,
    velocity: Floats,
    centre: Floats,
    ahead: Floats,
    half: Floats,
    shape: NDArray[np.int64],
    floor: float,
) -> NDArray[np.int64]:
    """The box and the flat voxel of it in which each ray ends that ends in one of R upright boxes.

    Args:
        image: The vehicle's rays.
        pose: The transform from its velodyne frame to the world, shape (4, 4).
        to_sensor: Its inverse.
        motion: The vehicle's speed, turn rate, and the period of its head.
        age: Seconds from when the boxes are at their places to the scan.
        velocity: The velocities of the boxes along the world's x and y, shape (R, 2).
        centre: Bottom centres of the boxes in the world, shape (R, 3).
        ahead: Cosines and sines of their headings, shape (R, 2).
        half: Half of their lengths, widths and heights, shape (R, 3).
        shape: Numbers of voxels along their sides, shape (R, 3).
        floor: Height above their bottoms up to which returns may be the ground's.

    Returns:
        Shape (2, E), the boxes rising.
    """
    period, azimuth, ends = motion[2], image.azimuth, image.end
    rays = np.empty(len(azimuth), np.int64)
    # Invariant: the first `count` columns are filled, box by box; before the rays of a box are
    # looked at one by one there is room for all of them.
    found, count = np.empty((2, 1024), np.int64), 0
    for b in range(len(centre)):
        # The rays that can end in the box, by cells, distances and heights.
        cells = _cells_of_box(image, to_sensor, motion, age, velocity[b], centre[b], half[b], floor)
        low, high = centre[b, 2] + floor, centre[b, 2] + 2.0 * half[b, 2]
        near = _rays_between(image, cells, pose[2], low, high, rays)
        while count + near > found.shape[1]:
            found = np.concatenate((found, np.empty_like(found)), axis=1)
        for i in rays[:near]:
            # Where it ends as seen from the box, where that was when the ray was sent.
            later = age + azimuth[i] * period / (2.0 * np.pi)
            x, y, z = through(pose, ends[i, 0], ends[i, 1], ends[i, 2])
            x -= centre[b, 0] + later * velocity[b, 0]
            y -= centre[b, 1] + later * velocity[b, 1]
            along = half[b, 0] + ahead[b, 0] * x + ahead[b, 1] * y
            across = half[b, 1] + ahead[b, 0] * y - ahead[b, 1] * x
            # Its voxel: by row, then by column, then by height.
            if 0.0 < along < 2.0 * half[b, 0] and 0.0 < across < 2.0 * half[b, 1]:
                voxel = min(int(along / VOXEL), shape[b, 0] - 1) * shape[b, 1]
                voxel += min(int(across / VOXEL), shape[b, 1] - 1)
                voxel *= shape[b, 2]
                voxel += min(int((z - centre[b, 2]) / VOXEL), shape[b, 2] - 1)
                found[0, count], found[1, count] = b, voxel
                count += 1
    return found[:, :count]


@kernel(nogil=True)
def _rays_between(
    image: RangeImage,
    cells: tuple[int, int, int, int, float, float],
    upward: Floats,
    low: float,
    high: float,
    rays: NDArray[np.int64],
) -> int:
    """Fills in the rays of some cells that end at some distances and heights; how many they are.

    Args:
        image: The vehicle's rays.
        cells: Cells and distances, as of `_cells_of_box`.
        upward: Row of the vehicle's pose that gives heights in the world, shape (4,).
        low: Height in the world above which they end, metres.
        high: Height below which they do, metres.
        rays: The array that takes their indices.
    """
    # A short loop over arrays that are bound outside of it: most rays are looked at here.
    distance, ends, count = image.distance, image.end, 0
    from_row, to_row, from_column, to_column, nearest, farthest = cells
    for row in range(from_row, to_row):
        for run in range(2):
            begin, end = run_of_rays(image, row, from_column, to_column, run)
            for i in range(begin, end):
                if not nearest < distance[i] < farthest:
                    continue
                z = upward[0] * ends[i, 0] + upward[1] * ends[i, 1] + upward[2] * ends[i, 2]
                if low < z + upward[3] < high:
                    rays[count] = i
                    count += 1
    return count


@kernel(nogil=True)
def fill_places(
    count: NDArray[np.int64],
    voxel: NDArray[np.int64],
    centre: Floats,
    ahead: Floats,
    half: Floats,
    shape: NDArray[np.int64],
    places: Floats,
) -> None:
    """Fills in the centres of voxels in the world, box by box.

    Args:
        count: Numbers of voxels of the boxes, shape (C,).
        voxel: Flat voxels of the first box, of the second, and so on, shape (V,).
        centre: Bottom centres of the boxes, as of `voxels_in_boxes`, shape (C, 3).
        ahead: Cosines and sines of their headings, as of `voxels_in_boxes`, shape (C, 2).
        half: Half of their sides, as of `voxels_in_boxes`, shape (C, 3).
        shape: Numbers of voxels along their sides, as of `voxels_in_boxes`, shape (C, 3).
        places: The array that takes the centres, shape (V, 3).
    """
    # Invariant: `v` is the number of voxels of the boxes before c, and of those done in it.
    v = 0
    for c in range(len(count)):
        cos, sin = ahead[c]
        for _ in range(count[c]):
            row, up = voxel[v] // shape[c, 2], voxel[v] % shape[c, 2]
            x = VOXEL * (row // shape[c, 1] + 0.5) - half[c, 0]
            y = VOXEL * (row % shape[c, 1] + 0.5) - half[c, 1]
            places[v, 0] = centre[c, 0] + cos * x - sin * y
            places[v, 1] = centre[c, 1] + sin * x + cos * y
            places[v, 2] = centre[c, 2] + VOXEL * (up + 0.5)
            v += 1


@kernel(nogil=True)
def _cells_of_box(
    image: RangeImage,
    to_sensor: Floats,
    motion: tuple[float, float, float],
    age: float,
    velocity: Floats,
    centre: Floats,
    half: Floats,
    floor: float,
) -> tuple[int, int, int, int, float, float]:
    """The cells, as of `cells_between`, and the distances of rays that can end in a moving box."""
    speed, turn_rate, period = motion
    x, y, z, azimuth, _, time, doubt = when_faced(to_sensor, motion, age, centre, velocity)
    away, lean = np.hypot(x, y), np.hypot(to_sensor[2, 0], to_sensor[2, 1])
    fast = abs(speed) + np.hypot(velocity[0], velocity[1])
    # Rays that end in it are sent at other times than that at which the head faces its middle: by
    # less, the fewer directions it fills, unless the head's turn ends there.  Seen from a sensor
    # that leans, the top stands beside the bottom.
    # Invariant: `off` is the most by which the times differ; it never grows.
    off, radius, side = period / 2.0 + abs(time), 0.0, 0.0
    for _ in range(3):
        radius = np.hypot(half[0], half[1]) + 2.0 * half[2] * lean + fast * off + _ROUNDING
        side = np.pi if away <= radius else np.arcsin(radius / away) + abs(turn_rate) * off
        if abs(azimuth) + side >= np.pi:
            break
        off = min(side * period / (2.0 * np.pi) + 2.0 * doubt, off)
    # How far up and down it reaches.
    bottom, top = floor * to_sensor[2, 2], 2.0 * half[2] * to_sensor[2, 2]
    low = z - TIP + min(bottom, top) - radius * lean - _ROUNDING
    high = z - TIP + max(bottom, top) + radius * lean + _ROUNDING
    near, far = max(away - radius, 0.0), away + radius
    from_row, to_row, from_column, to_column = cells_between(
        azimuth - side,
        azimuth + side,
        np.arctan2(low, near if low < 0.0 else far),
        np.arctan2(high, near if high > 0.0 else far),
    )
    from_view, to_view = rows_of_view(image)
    return (
        max(from_row, from_view),
        min(to_row, to_view),
        from_column,
        to_column,
        np.hypot(near, max(low, -high, 0.0)),
        np.hypot(far, max(-low, high)),
    )
