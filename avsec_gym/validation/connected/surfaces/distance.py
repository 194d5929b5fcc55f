"""The distance of two discretised surfaces (thesis, section 4.4.4, equations 4.1 and 4.2)."""

from __future__ import annotations

import numpy as np

from avsec_gym.errors import DataError
from avsec_gym.geometry import Floats

THESIS_EPSILON = 0.04
"""Metres: the thesis' mean distance between surfaces of the ground."""


def surface_distance(first: Floats, second: Floats, epsilon: float = THESIS_EPSILON) -> float:
    """dist_{i,j1,j2}: the mean difference of two surfaces where they differ at all.

    Args:
        first: dsm_{i,j1}, heights in metres, NaN where there is no surface, shape (H, W).
        second: dsm_{i,j2}, of the same region.
        epsilon: Cells that differ by no more are ground, or alike, and do not count, metres.

    Returns:
        Metres, 0 or more; 0 where no cell differs by more than epsilon; NaN where no cell has a
        height in both, so that nothing was compared.

    Raises:
        DataError: The grids differ in shape.

    Example:
        >>> surface_distance(np.zeros((2, 2)), np.array([[0, 0.03], [0.5, 1.5]]))
        1.0
    """
    difference = cell_differences(first, second)
    if not len(difference):
        return float("nan")
    different = difference[difference > epsilon]
    return float(different.mean()) if len(different) else 0.0


def distances_of_all(grids: list[Floats | None], epsilon: float = THESIS_EPSILON) -> Floats:
    """The distances of every pair of vehicles in a region, shape (n, n), symmetric.

    Args:
        grids: dsm of each vehicle; None of one that sent nothing.
        epsilon: Metres by which cells may differ and not count, see `surface_distance`.

    Returns:
        NaN where a pair compared nothing, and on the diagonal.
    """
    distances = np.full((len(grids), len(grids)), np.nan)
    for i, first in enumerate(grids):
        for j, second in enumerate(grids[:i]):
            if first is not None and second is not None:
                distances[i, j] = distances[j, i] = surface_distance(first, second, epsilon)
    return distances


def cell_differences(first: Floats, second: Floats) -> Floats:
    """Absolute differences of the cells that have a height in both grids, shape (M,).

    Raises:
        DataError: The grids differ in shape.
    """
    if first.shape != second.shape:
        raise DataError(
            f"two grids of one region have one shape, got {first.shape} and {second.shape}"
        )
    difference = np.abs(first - second)
    return difference[np.isfinite(difference)]
