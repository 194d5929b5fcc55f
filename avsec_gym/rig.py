"""`SensorRig`: which sensors a vehicle carries, and where.

The *vehicle frame* has its origin on the ground below camera 0, x forward, y left, z up; its axes
are those of the rectified cameras.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Calibration
from avsec_gym.geometry import Floats

KITTI_FOCAL_LENGTH = 721.5377
KITTI_CENTRE = (609.5593, 172.854)
KITTI_SIZE = (1242, 375)
"""Width and height, pixels."""
KITTI_CAMERAS = (0.0, 387.5744 / 721.5377, -44.85728 / 721.5377, 339.5242 / 721.5377)
"""How far right of camera 0 the cameras 0 (grey, left), 1 (grey, right), 2 and 3 (colour) are."""

FARTHEST_CAMERA = 5.0
"""Metres from camera 0: no car is as wide."""
LEAST_BASELINE = 0.01
"""Metres between two cameras: cameras at one place see one picture, and no depth."""

_CAMERA_AXES = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
_VELODYNE_IN_VEHICLE = (-0.27, 0.0, 1.73)
_VELODYNE_ANGLES = (-0.0007, 0.0148, 0.0100)
_IMU_IN_VELODYNE = (-0.81, 0.32, -0.80)
_IMU_ANGLES = (0.0020, 0.0008, -0.0005)
_RECTIFYING_ANGLES = (0.0044, -0.0075, 0.0098)


@dataclass(frozen=True, eq=False)
class SensorRig:
    """Rectified cameras side by side, a LiDAR and an inertial unit.

    Args:
        calibration: The calibration in KITTI's terms.
        size: Width and height of all images, pixels.
        camera_height: The height of the cameras above the ground, metres.
    """

    calibration: Calibration
    size: tuple[int, int] = KITTI_SIZE
    camera_height: float = 1.65

    @property
    def cameras(self) -> tuple[int, ...]:
        """Numbers of the cameras."""
        return self.calibration.cameras

    @property
    def stereo_pair(self) -> tuple[int, int | None]:
        """The labelled reference camera, and the camera that its disparities belong to.

        KITTI's colour cameras 2 and 3 where 3 is right of 2, else the leftmost and the rightmost
        one; None for a rig with a single camera.
        """
        right_of = {i: float(self.calibration.camera_centre(i)[0]) for i in self.cameras}
        if 2 in right_of and right_of.get(3, -np.inf) > right_of[2]:
            return 2, 3
        leftmost, rightmost = (
            min(right_of, key=right_of.__getitem__),
            max(right_of, key=right_of.__getitem__),
        )
        return leftmost, rightmost if rightmost != leftmost else None

    @property
    def camera_to_vehicle(self) -> Floats:
        """From the rectified frame of camera 0 to the vehicle frame, shape (4, 4)."""
        result = np.eye(4)
        result[:3, :3] = _CAMERA_AXES.T
        result[2, 3] = self.camera_height
        return result

    def camera_pose(self, camera: int) -> Floats:
        """From a camera's own frame (x right, y down, z forward) to the vehicle frame."""
        offset = np.eye(4)
        offset[:3, 3] = self.calibration.camera_centre(camera)
        return np.asarray(self.camera_to_vehicle @ offset)

    @property
    def velodyne_pose(self) -> Floats:
        """From the velodyne frame to the vehicle frame, shape (4, 4)."""
        return np.asarray(self.camera_to_vehicle @ self.calibration.velodyne_to_camera)

    @property
    def imu_pose(self) -> Floats:
        """From the frame of the inertial unit to the vehicle frame, shape (4, 4).

        Raises:
            ConfigurationError: The rig has none.
        """
        if self.calibration.tr_imu_to_velo is None:
            raise ConfigurationError("this rig has no inertial unit (no Tr_imu_to_velo)")
        transform = np.vstack([self.calibration.tr_imu_to_velo, [0.0, 0.0, 0.0, 1.0]])
        return np.asarray(self.velodyne_pose @ transform)


def kitti_rig() -> SensorRig:
    """KITTI's: cameras 0 to 3 with its baselines and intrinsics, and a Velodyne on the roof."""
    return camera_rig(KITTI_CAMERAS)


def resized_rig(rig: SensorRig, width: int) -> SensorRig:
    """The same sensors with images of another width, as if each had been resampled.

    Args:
        rig: The sensors of the vehicle that looks.
        width: Width of the new images, pixels; the height follows.

    Raises:
        ConfigurationError: The width is below 16 pixels.
    """
    if width < 16:
        raise ConfigurationError(f"images are 16 pixels wide or more, got {width}")
    share = width / rig.size[0]
    # Pixel centres have whole numbers: the image's corner lies half a pixel before the first.
    shift = 0.5 * share - 0.5
    resample = np.array([[share, 0.0, shift], [0.0, share, shift], [0.0, 0.0, 1.0]])
    calibration = replace(rig.calibration, projections=resample @ rig.calibration.projections)
    return replace(rig, calibration=calibration, size=(width, round(share * rig.size[1])))


def camera_rig(
    right_of_camera_0: Sequence[float],
    *,
    focal_length: float = KITTI_FOCAL_LENGTH,
    centre: tuple[float, float] = KITTI_CENTRE,
    size: tuple[int, int] = KITTI_SIZE,
) -> SensorRig:
    """Any number of cameras in a row, otherwise KITTI's rig.

    Args:
        right_of_camera_0: How far right of camera 0 each camera is, metres.
        focal_length: Pixels.
        centre: Principal point, pixels.
        size: Width and height of the images, pixels.

    Raises:
        ConfigurationError: No camera at all, no positive focal length or size, or cameras that do
            not stand beside each other on a car.

    Example:
        >>> rig = camera_rig([0.0, 0.2, 0.4, 0.6])
        >>> round(rig.calibration.baseline(0, 3), 3)
        0.6
    """
    if not right_of_camera_0 or focal_length <= 0 or min(size) <= 0:
        raise ConfigurationError(
            "a rig has a camera or more, and a positive focal length and size; got "
            f"{len(right_of_camera_0)} cameras, {focal_length} px and {size}"
        )
    places = np.sort(np.asarray(right_of_camera_0, float))
    if not (np.abs(places) <= FARTHEST_CAMERA).all() or (np.diff(places) < LEAST_BASELINE).any():
        raise ConfigurationError(
            f"the cameras of a rig stand at most {FARTHEST_CAMERA:g} m from camera 0 and at least"
            f" {1000 * LEAST_BASELINE:g} mm from each other, got"
            f" {' '.join(f'{place:g}' for place in right_of_camera_0)} m"
        )
    intrinsic = np.array([[focal_length, 0, centre[0]], [0, focal_length, centre[1]], [0, 0, 1]])
    projections = np.stack(
        [intrinsic @ np.c_[np.eye(3), [-right, 0.0, 0.0]] for right in right_of_camera_0]
    )
    rectification = _rotation(*_RECTIFYING_ANGLES)
    velodyne = _CAMERA_AXES @ _rotation(*_VELODYNE_ANGLES)
    position = _CAMERA_AXES @ (np.array(_VELODYNE_IN_VEHICLE) - [0.0, 0.0, 1.65])
    # KITTI's Tr_velo_to_cam ends in the frame before rectification.
    return SensorRig(
        Calibration(
            projections,
            rectification,
            rectification.T @ np.c_[velodyne, position],
            np.c_[_rotation(*_IMU_ANGLES), _IMU_IN_VELODYNE],
        ),
        size,
    )


def _rotation(roll: float, pitch: float, yaw: float) -> Floats:
    cr, sr, cp, sp, cy, sy = (f(angle) for angle in (roll, pitch, yaw) for f in (np.cos, np.sin))
    about_x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    about_z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return np.asarray(about_z @ about_y @ about_x)
