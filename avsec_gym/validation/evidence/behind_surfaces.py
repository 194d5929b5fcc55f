"""Scan points that stand behind what two cameras see: no beam goes through a surface.

A LiDAR sees past a near thing what a camera beside it does not see, so that its points lie behind
the camera's surfaces along every edge.  Seen from the LiDAR itself they do not: there, only a point
with nearer surfaces on all sides is behind them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.frame import Calibration
from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel
from avsec_gym.kitti.map_files import Disparity
from avsec_gym.validation.evidence.comparison import MIN_DIFFERENCE
from avsec_gym.validation.evidence.reprojection import Mask

MIN_NEARER = 0.25
"""Share of a point's disparity that a nearer surface has more: it is nearer by a fifth."""
MIN_SURROUNDED = 0.9
"""Share of the surfaces on each side of a point, as the LiDAR sees it, that are nearer."""
MIN_KNOWN = 0.5
"""Share of what is on each side that has to be known: what only the LiDAR sees is not."""
AROUND = 16
"""Pixels to each side; matchers make near things wider by up to some eight."""
STEP = 2
"""The step from one of these pixels to the next one that is looked at."""


class LidarEye(NamedTuple):
    """A camera of the reference's optics where the LiDAR is.

    Args:
        focal_length: The focal length, pixels.
        u: The column of the optical axis, pixels.
        v: The row of the optical axis, pixels.
        place: The place of the LiDAR in the reference camera's frame, metres, shape (3,).
        scale: Disparity times depth, in pixels and metres, of the maps that are compared.
    """

    focal_length: float
    u: float
    v: float
    place: Floats
    scale: float


def lidar_eye(calibration: Calibration, camera: int, scale: float) -> LidarEye:
    """The eye of a rig; `scale` is a disparity map's `focal_times_baseline`."""
    projection = calibration.projection(camera)
    offset = np.linalg.solve(projection[:, :3], projection[:, 3])
    place = calibration.velodyne_to_camera[:3, 3] + offset
    return LidarEye(
        float(projection[0, 0]), float(projection[0, 2]), float(projection[1, 2]), place, scale
    )


def behind_surfaces(scan: Disparity, dense: Disparity, eye: LidarEye) -> Mask:
    """Pixels of scan points that are behind surfaces on all sides, as the LiDAR sees them.

    Nearer is what has `MIN_DIFFERENCE` pixels of disparity more, and `MIN_NEARER`.

    Args:
        scan: DM_{0,k}, in the scale of the dense one, shape (H, W).
        dense: DM_{j,k}, the same shape.
        eye: The LiDAR in the view of the reference camera k.

    Returns:
        Shape (H, W); false where there is no point.
    """
    focal, u, v, (x, y, z), scale = eye
    moved = np.array([focal, u, v, x, y, z, scale])
    return _behind(scan, dense, _from_the_lidar(dense, moved), moved)


@kernel(nogil=True)
def _seen_from(
    row: int, column: int, disparity: float, eye: NDArray[np.float64]
) -> tuple[float, float, float]:
    """Row, column and depth in the LiDAR's view of what a pixel of the reference sees."""
    focal, u, v, x, y, z, scale = eye
    depth = scale / disparity
    ahead = depth - z
    if ahead <= 0.1:
        return -1e6, -1e6, 1.0
    across = (column - u) / focal * depth - x
    down = (row - v) / focal * depth - y
    return down / ahead * focal + v, across / ahead * focal + u, ahead


@kernel(nogil=True)
def _from_the_lidar(dense: Disparity, eye: NDArray[np.float64]) -> Disparity:
    """The nearest surface in each pixel of the LiDAR's view, as disparity; 0 where none is."""
    height, width = dense.shape
    scale = eye[6]
    result = np.zeros((height, width), np.float32)
    for i in range(height):
        for j in range(width):
            # Also NaN is not above.
            if not dense[i, j] > 0.01:
                continue
            row, column, ahead = _seen_from(i, j, dense[i, j], eye)
            r, first = int(np.rint(row)), int(np.floor(column))
            if not 0 <= r < height:
                continue
            # Both neighbours in the row, so that surfaces leave no cracks.
            for c in range(max(first, 0), min(first + 2, width)):
                result[r, c] = max(result[r, c], scale / ahead)
    return result


@kernel(nogil=True)
def _behind(
    scan: Disparity, dense: Disparity, surfaces: Disparity, eye: NDArray[np.float64]
) -> Mask:
    # `surfaces` are in the LiDAR's view, `scan` and `dense` in the camera's; all of one scale.
    height, width = scan.shape
    scale = eye[6]
    result = np.zeros((height, width), np.bool_)
    for i in range(height):
        for j in range(width):
            here = scan[i, j]
            # Of most points the camera itself sees that nothing is before them.
            if not (here > 0.01 and dense[i, j] - here > MIN_DIFFERENCE):
                continue
            row, column, ahead = _seen_from(i, j, here, eye)
            own = scale / ahead
            least = own + max(MIN_DIFFERENCE, MIN_NEARER * own)
            result[i, j] = _is_surrounded(surfaces, int(np.rint(row)), int(np.rint(column)), least)
    return result


@kernel(nogil=True)
def _is_surrounded(surfaces: Disparity, row: int, column: int, least: float) -> bool:
    """Whether on each of four sides of a pixel enough is known, and nearer."""
    # The row and the column of the pixel itself belong to two sides each; `known` counts at least
    # what `nearer` counts.
    height, width = surfaces.shape
    known, nearer = np.zeros(4), np.zeros(4)
    for n in range(-AROUND, AROUND + 1, STEP):
        for m in range(-AROUND, AROUND + 1, STEP):
            if not (0 <= row + n < height and 0 <= column + m < width):
                continue
            disparity = surfaces[row + n, column + m]
            sides = (m <= 0, m >= 0, n <= 0, n >= 0)
            for side in range(4):
                if sides[side]:
                    known[side] += disparity > 0
                    nearer[side] += disparity > least
    whole = (AROUND + 1) * (AROUND // STEP + 1)
    for side in range(4):
        if known[side] < MIN_KNOWN * whole or nearer[side] < MIN_SURROUNDED * known[side]:
            return False
    return True
