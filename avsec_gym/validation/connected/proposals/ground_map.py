"""The ground about a vehicle, as a map of heights: what is wider than any vehicle, and low."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from avsec_gym.geometry import Floats

_CELL = 1.0
_WIDEST = 7
"""Cells: bumps that are narrower in one direction stand on the ground."""


@dataclass(frozen=True, eq=False)
class GroundMap:
    """Heights of the ground in cells of a square about the sensor.

    Args:
        heights: Heights in the velodyne frame, metres, shape (K, K): rows along x.
        reach: Half the side of the square, metres.
    """

    heights: Floats
    reach: float

    def height(self, places: Floats) -> Floats:
        """Heights z of the ground at places (N, 2), between cells as on planes; shape (N,)."""
        cells = ((places + self.reach) / _CELL - 0.5).T
        heights: Floats = ndimage.map_coordinates(self.heights, cells, order=1, mode="nearest")
        return heights


def ground_map(places: Floats, reach: float) -> GroundMap:
    """The ground under a scan.

    The lowest point of each cell is ground, except where it is on a roof: a morphological opening
    takes away what stands out of its surroundings and is narrower than 7 m.

    Args:
        places: Points of a scan, velodyne frame, shape (N, 3), N at least 1.
        reach: Half the side of the map, metres; all points are within.
    """
    count = int(np.ceil(2 * reach / _CELL))
    cells = np.clip(((places[:, :2] + reach) / _CELL).astype(int), 0, count - 1)
    lowest = np.full((count, count), np.inf)
    np.minimum.at(lowest, (cells[:, 0], cells[:, 1]), places[:, 2])
    # A cell without points is as high as the nearest that has some.
    unknown = np.isinf(lowest)
    if unknown.any():
        nearest = ndimage.distance_transform_edt(
            unknown, return_distances=False, return_indices=True
        )
        lowest = lowest[tuple(nearest)]
    opened = ndimage.grey_opening(lowest, size=(_WIDEST, _WIDEST), mode="nearest")
    return GroundMap(opened, reach)
