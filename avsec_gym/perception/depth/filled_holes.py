"""Holes of a disparity map filled as KITTI's development kit fills them before it counts errors."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from avsec_gym.frame import SensorFrame
from avsec_gym.kernels import kernel
from avsec_gym.kitti.map_files import Disparity
from avsec_gym.perception.depth.depth import DepthEstimator, DisparityMap


@dataclass(frozen=True)
class FilledHoles:
    """A depth estimator whose holes are filled, so that every pixel has a disparity.

    A matcher has no answer where light leaves nothing to match, and no answer contradicts nothing.
    What is filled in is a guess that can be contradicted.

    Args:
        estimator: The estimator whose maps are filled.
    """

    name: ClassVar[str] = "filled_holes"
    estimator: DepthEstimator

    def disparity(self, frame: SensorFrame) -> DisparityMap:
        """See `DepthEstimator`."""
        found = self.estimator.disparity(frame)
        return replace(found, values=filled_holes(found.values))


def filled_holes(disparity: Disparity) -> Disparity:
    """A map whose holes are filled by what is behind them; all NaN stays all NaN.

    In each row a hole gets the smaller disparity of its two ends, that at the border the one that
    it has; rows without any get those of the nearest row above, the first ones of that below.

    Args:
        disparity: The map, pixels, NaN where unknown, shape (H, W).

    Source:
        Menze and Geiger 2015, development kit of the stereo benchmark: the background
        interpolation of its ``io_disp.h``.

    Example:
        >>> nan = np.nan
        >>> filled_holes(np.array([[nan, 4, nan, 2, nan], [nan] * 5], np.float32)).tolist()
        [[4.0, 4.0, 2.0, 2.0, 2.0], [4.0, 4.0, 2.0, 2.0, 2.0]]
    """
    return _filled(np.ascontiguousarray(disparity, np.float32))


@kernel(nogil=True)
def _filled(disparity: Disparity) -> Disparity:
    height, width = disparity.shape
    result = disparity.copy()
    for v in range(height):
        # Invariant: `last` is the column of the last known pixel before u, -1 before the first; up
        # to it all are filled.
        last = -1
        for u in range(width):
            if np.isnan(disparity[v, u]):
                continue
            here = disparity[v, u]
            behind = here if last < 0 else min(here, disparity[v, last])
            for column in range(last + 1, u):
                result[v, column] = behind
            last = u
        if last >= 0:
            for column in range(last + 1, width):
                result[v, column] = disparity[v, last]
    # A row is known throughout by now, or not at all.
    # Invariant: the rows from `first` to v - 1 are known; -1: none is.
    first = -1
    for v in range(height):
        if width and not np.isnan(result[v, 0]):
            first = v if first < 0 else first
        elif first >= 0:
            result[v] = result[v - 1]
    for v in range(first):
        result[v] = result[first]
    return result
