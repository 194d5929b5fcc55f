"""Scan points that are not there, as two cameras see.

A scan and a disparity map contradict each other in every treetop, since matchers smooth what is
thin, and on every plain wall.  The images may show which of them is right: around a pixel they
look alike where the disparity is right.  A bogus return stands before what both cameras see, and
there they look alike without it; or behind it, where no beam comes from.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from avsec_gym.frame import Image
from avsec_gym.kernels import kernel
from avsec_gym.kitti.map_files import Disparity
from avsec_gym.perception.depth.depth import DisparityMap
from avsec_gym.validation.evidence.behind_surfaces import LidarEye, behind_surfaces
from avsec_gym.validation.evidence.brightness import without_colours
from avsec_gym.validation.evidence.comparison import Comparison, comparison_map
from avsec_gym.validation.evidence.reprojection import Mask

MIN_EVIDENCE = 0.15
"""Share of the pixels around by which two images look less alike where a scan point puts them."""
NOISE = 3
"""Grey levels; pixels that differ by less are as bright."""
_ROWS, _COLUMNS = 5, 6
"""Pixels around that are compared: up and down, left and right."""


def disproved_points(
    scan: DisparityMap, dense: DisparityMap, image: Image, other: Image, eye: LidarEye
) -> Mask:
    """Pixels of scan points that contradict the cameras, and that the images disprove.

    They stand nearer than the cameras measure, or behind what these see, see `behind_surfaces`.

    Each of the pixels around one is darker than the middle, as bright, or brighter, and so in both
    images if they show the same: the census of Zabih and Woodfill (1994), which minds little how
    cameras are exposed, with a third state for `NOISE`, so that plain surfaces look alike anywhere.

    Args:
        scan: DM_{0,k}, in any scale.
        dense: The map of the cameras, DM_{j,k}.
        image: The image of the reference k, shape (H, W, 3).
        other: The image of camera j to its right.
        eye: Where the LiDAR is, in the view of the reference and the scale of the dense map.

    Returns:
        Shape (H, W).

    Raises:
        ConfigurationError: The maps differ in shape.
    """
    here = scan.rescaled(dense.focal_times_baseline).values
    compared = comparison_map(scan, dense)
    nearer = (compared == Comparison.INCONSISTENT) & (here > dense.values)
    rows, columns = np.nonzero(nearer | behind_surfaces(here, dense.values, eye))
    result = np.zeros(here.shape, bool)
    if len(rows):
        left, right = (_smooth_grey(seen) for seen in (image, other))
        result[rows, columns] = _is_disproved(left, right, rows, columns, here, dense.values)
    return result


def _smooth_grey(image: Image) -> NDArray[np.uint8]:
    return np.asarray(cv2.blur(without_colours(image)[..., 0], (3, 3)), np.uint8)


@kernel(nogil=True)
def _is_disproved(
    left: NDArray[np.uint8],
    right: NDArray[np.uint8],
    rows: NDArray[np.intp],
    columns: NDArray[np.intp],
    scan: Disparity,
    dense: Disparity,
) -> Mask:
    # `rows` and `columns` are those of pixels with a scan point and a disparity in the dense map.
    result = np.empty(len(rows), np.bool_)
    for point in range(len(rows)):
        v, u = rows[point], columns[point]
        without = _unlike(left, right, v, u, dense[v, u])
        # What is out of the other camera's sight, is not disproved: NaN is above nothing.
        result[point] = _unlike(left, right, v, u, scan[v, u]) - without > MIN_EVIDENCE
    return result


@kernel(nogil=True)
def _unlike(
    left: NDArray[np.uint8], right: NDArray[np.uint8], v: int, u: int, disparity: float
) -> float:
    """Share of the pixels around that differ in census, of three columns the best; NaN outside."""
    # Only pixels that are in both images are compared, so that no index leaves an image.
    height, width = left.shape
    best = np.nan
    middle = round(u - disparity)
    for column in range(max(middle - 1, 0), min(middle + 2, width)):
        differing, count = 0, 0
        for i in range(max(-_ROWS, -v), min(_ROWS, height - 1 - v) + 1):
            reach_left, reach_right = min(u, column), min(width - 1 - u, width - 1 - column)
            for j in range(max(-_COLUMNS, -reach_left), min(_COLUMNS, reach_right) + 1):
                one = _census(left[v + i, u + j], left[v, u])
                differing += one != _census(right[v + i, column + j], right[v, column])
                count += 1
        # Half of them at least have to be in both images.
        if 2 * count >= (2 * _ROWS + 1) * (2 * _COLUMNS + 1):
            best = differing / count if np.isnan(best) else min(best, differing / count)
    return best


@kernel(nogil=True)
def _census(level: int, middle: int) -> int:
    # Levels have no sign: they are not subtracted.
    return int(level > middle + NOISE) - int(level + NOISE < middle)
