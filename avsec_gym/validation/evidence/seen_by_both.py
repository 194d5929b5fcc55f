"""What only one of two cameras sees has no disparity, whatever a network answers there."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from avsec_gym.frame import SensorFrame
from avsec_gym.kernels import kernel
from avsec_gym.kitti.map_files import Disparity
from avsec_gym.perception.depth.depth import DepthEstimator, DisparityMap
from avsec_gym.validation.evidence.comparison import MIN_DIFFERENCE, MIN_RELATIVE_DIFFERENCE
from avsec_gym.validation.evidence.reprojection import Mask


@dataclass(frozen=True)
class SeenByBoth:
    """A depth estimator without what it guesses: pixels that are hidden from the other camera.

    Semi-global matching leaves holes there.  A network is trained to answer everywhere: beside
    every near object it continues what is behind, which the other camera does not see, so that no
    two images can be compared there.

    Args:
        estimator: The estimator whose maps are cleaned.
    """

    name: ClassVar[str] = "seen_by_both"
    estimator: DepthEstimator

    def disparity(self, frame: SensorFrame) -> DisparityMap:
        """See `DepthEstimator`."""
        found = self.estimator.disparity(frame)
        values = np.where(seen_by_both(found.values), found.values, np.float32(np.nan))
        return replace(found, values=values)


def seen_by_both(disparity: Disparity) -> Mask:
    """Which pixels the camera to the right sees, too, if the map is right.

    A pixel is hidden where another one of its row comes to lie on it, or on a neighbour, that is
    nearer by what equation 3.2 calls inconsistent; and outside of the other image.

    Args:
        disparity: Disparity of the left camera, pixels, NaN where unknown, shape (H, W).
    """
    return _seen_by_both(np.ascontiguousarray(disparity, np.float32))


@kernel(nogil=True)
def _seen_by_both(disparity: Disparity) -> Mask:
    # After the first pass over a row `nearest` holds, for each column of the other image, the
    # largest disparity that falls on it; the second pass compares each pixel with it.
    height, width = disparity.shape
    result = np.zeros((height, width), np.bool_)
    nearest = np.empty(width + 2, np.float32)
    for v in range(height):
        nearest[:] = -1.0
        for u in range(width):
            if 0 <= disparity[v, u] <= u:
                # One to the right: the border needs no case of its own.
                column = round(u - disparity[v, u]) + 1
                nearest[column] = max(nearest[column], disparity[v, u])
        for u in range(width):
            if 0 <= disparity[v, u] <= u:
                column = round(u - disparity[v, u]) + 1
                here = disparity[v, u]
                most = max(nearest[column - 1], nearest[column], nearest[column + 1])
                tolerated = max(MIN_DIFFERENCE, MIN_RELATIVE_DIFFERENCE * here)
                result[v, u] = most - here <= tolerated
    return result
