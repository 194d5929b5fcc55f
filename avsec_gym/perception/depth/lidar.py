"""A LiDAR scan as a sparse disparity map (thesis, section 3.3.2: d = f b / z)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from avsec_gym.argument_checks import camera_number
from avsec_gym.frame import Calibration, Points, SensorFrame
from avsec_gym.geometry import Floats, project, transform_points
from avsec_gym.kitti.map_files import Disparity
from avsec_gym.perception.depth.depth import DisparityMap, pair_scale

_NEAREST = 0.5


@dataclass(frozen=True)
class LidarDepth:
    """The scan projected into the reference image; of the points in a pixel the nearest counts."""

    name: ClassVar[str] = "lidar"
    left: int = 2
    """Reference camera."""
    right: int = 3
    """The camera whose baseline the disparities are for."""

    def __post_init__(self) -> None:
        camera_number("left", self.left)
        camera_number("right", self.right)

    def disparity(self, frame: SensorFrame) -> DisparityMap:
        """See `DepthEstimator`."""
        height, width = frame.image(self.left).shape[:2]
        values = scan_disparity(
            frame.points, frame.calibration, (height, width), (self.left, self.right)
        )
        return DisparityMap(values, pair_scale(frame, self.left, self.right))


def scan_disparity(
    points: Points, calibration: Calibration, shape: tuple[int, int], cameras: tuple[int, int]
) -> Disparity:
    """A LiDAR scan as a sparse disparity map; of the points in one pixel the nearest counts.

    Args:
        points: The points, shape (M, 4).
        calibration: The calibration of the rig.
        shape: Height and width of the images.
        cameras: Left and right.

    Returns:
        Of the left camera, shape (H, W), pixels, NaN where there is no point.
    """
    left, right = cameras
    uv, depth, _ = visible_points(points, calibration, shape, left)
    pixel = np.round(uv).astype(np.int64)
    disparity = np.full(shape, np.nan, np.float32)
    scale = calibration.focal_length(left) * calibration.baseline(left, right)
    disparity[pixel[:, 1], pixel[:, 0]] = scale / depth
    return disparity


def visible_points(
    points: Points, calibration: Calibration, shape: tuple[int, int], camera: int
) -> tuple[Floats, Floats, NDArray[np.int64]]:
    """The points of a scan that are the nearest in their pixel.

    Args:
        points: The points, shape (M, 4).
        calibration: The calibration of the rig.
        shape: Height and width of the image.
        camera: The camera whose map is wanted.

    Returns:
        Where they are in the image (u, v), their depths in metres, and their indices.
    """
    places = transform_points(calibration.velodyne_to_camera, points[:, :3])
    uv, depth = project(calibration.projection(camera), places)
    ahead = np.flatnonzero(depth > _NEAREST)
    pixel = np.round(uv[ahead]).astype(np.int64)
    inside = ((pixel >= 0) & (pixel < (shape[1], shape[0]))).all(axis=1)
    pixel, index = pixel[inside], ahead[inside]
    order = np.argsort(depth[index], kind="stable")
    pixel, index = pixel[order], index[order]
    _, first = np.unique(pixel[:, 1] * shape[1] + pixel[:, 0], return_index=True)
    return uv[index[first]], depth[index[first]], index[first]
