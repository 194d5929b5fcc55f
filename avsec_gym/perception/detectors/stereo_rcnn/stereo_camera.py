"""`StereoCamera`: a rectified pair in the frame of its left camera, where the solver works."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from avsec_gym.geometry import Floats


@dataclass(frozen=True, eq=False)
class StereoCamera:
    """Two parallel pinhole cameras; x right, y down, z forward from the left one, metres.

    Args:
        focal_length: Horizontal and vertical, pixels.
        centre: Principal point (u, v), pixels.
        baseline: How far the right camera is to the right of the left one, metres.
        offset: What a location in KITTI's frame (of camera 0) gains in the left camera's, metres.
        size: Height and width of the images, pixels.
    """

    focal_length: tuple[float, float]
    centre: tuple[float, float]
    baseline: float
    offset: tuple[float, float, float]
    size: tuple[int, int]

    @classmethod
    def of_projections(
        cls, left: ArrayLike, right: ArrayLike, size: tuple[int, int]
    ) -> StereoCamera:
        """The camera of KITTI's two matrices P, of shape (3, 4), and of the images' size."""
        left, right = np.asarray(left, float), np.asarray(right, float)
        offset = np.linalg.solve(left[:, :3], left[:, 3])
        baseline = (left[0, 3] - right[0, 3]) / left[0, 0]
        return cls(
            (float(left[0, 0]), float(left[1, 1])),
            (float(left[0, 2]), float(left[1, 2])),
            float(baseline),
            (float(offset[0]), float(offset[1]), float(offset[2])),
            size,
        )

    @property
    def focal_times_baseline(self) -> float:
        """Depth times disparity, metres x pixels."""
        return self.focal_length[0] * self.baseline

    def rays(self, pixels: ArrayLike) -> Floats:
        """Pixels (..., 2) as u, v on the plane one metre ahead, shape (..., 2)."""
        return np.asarray((np.asarray(pixels, float) - self.centre) / np.array(self.focal_length))
