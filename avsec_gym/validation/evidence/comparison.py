"""Where two disparity maps of one view contradict each other (thesis, equation 3.2)."""

from __future__ import annotations

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import ConfigurationError
from avsec_gym.kernels import kernel
from avsec_gym.kitti.map_files import Disparity
from avsec_gym.perception.depth.depth import DisparityMap

MIN_DIFFERENCE = 3.0
"""Pixels (equation 3.2)."""
MIN_RELATIVE_DIFFERENCE = 0.05
"""Share of the smaller disparity."""


class Comparison(IntEnum):
    """How two maps agree at a pixel."""

    UNKNOWN = 0
    """Neither map knows it."""
    FIRST_ONLY = 1
    """A hole of the second map."""
    SECOND_ONLY = 2
    """A hole of the first map, or a gap between a scan's points."""
    CONSISTENT = 3
    INCONSISTENT = 4


def comparison_map(first: DisparityMap, second: DisparityMap) -> NDArray[np.uint8]:
    """Which `Comparison` holds at each pixel, in the scale of the second map.

    Returns:
        Shape (H, W).
    """
    if first.values.shape != second.values.shape:
        raise ConfigurationError(
            f"two maps of one view have one shape, got {first.values.shape} and "
            f"{second.values.shape}"
        )
    return _compare(first.rescaled(second.focal_times_baseline).values, second.values)


@kernel(nogil=True)
def _compare(first: Disparity, second: Disparity) -> NDArray[np.uint8]:
    # Both maps have one scale and one shape; every pixel of the result is written once.
    height, width = first.shape
    result = np.empty((height, width), np.uint8)
    for v in range(height):
        for u in range(width):
            a, b = first[v, u], second[v, u]
            if np.isnan(a):
                result[v, u] = Comparison.UNKNOWN if np.isnan(b) else Comparison.SECOND_ONLY
            elif np.isnan(b):
                result[v, u] = Comparison.FIRST_ONLY
            else:
                difference = abs(a - b)
                # Not divided by the smaller one, which may be 0.
                if difference > MIN_DIFFERENCE and difference > MIN_RELATIVE_DIFFERENCE * min(a, b):
                    result[v, u] = Comparison.INCONSISTENT
                else:
                    result[v, u] = Comparison.CONSISTENT
    return result
