"""A LiDAR scan as the network sees it: which cells hold points, and how bright they are."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avsec_gym.frame import Points
from avsec_gym.perception.detectors.pixor.configuration import BirdEyeRegion


def bird_eye_input(points: Points, region: BirdEyeRegion) -> NDArray[np.float32]:
    """Occupancy of every slice, and the mean reflectance of every column of cells.

    Args:
        points: The points, shape (M, 4), velodyne frame; those on the region's border are outside,
            as are those that are not finite.
        region: What is seen.

    Returns:
        Shape (slices + 1, rows, columns): 1 where a slice of a cell holds a point, else 0; last,
        the mean reflectance over all slices, 0 where there is none.

    Example:
        >>> region = BirdEyeRegion((0, 2), (0, 1), (0, 1), 1, 0.5)
        >>> bird_eye_input(np.float32([[1.5, 0.5, 0.7, 0.25]]), region).squeeze().tolist()
        [[0.0, 0.0], [0.0, 1.0], [0.0, 0.25]]
    """
    ranges = np.array([region.forward, region.left, region.up])
    sizes = np.array([region.cell, region.cell, region.slice])
    places = points[:, :3]
    inside = ((places > ranges[:, 0]) & (places < ranges[:, 1])).all(axis=1)
    index = ((places[inside] - ranges[:, 0]) / sizes).astype(np.int64)
    # A division may round up to the far border.
    column, row, layer = np.minimum(
        index, [region.columns - 1, region.rows - 1, region.slices - 1]
    ).T
    grid = np.zeros(region.shape, np.float32)
    grid[layer, row, column] = 1.0
    cell, cells = row * region.columns + column, region.rows * region.columns
    reflectance = np.bincount(cell, points[inside, 3], cells)
    grid[-1] = (reflectance / np.maximum(np.bincount(cell, minlength=cells), 1)).reshape(
        region.rows, region.columns
    )
    return grid
