"""The recording car's motion by its inertial and satellite unit, as the camera makes it."""

from __future__ import annotations

import numpy as np

from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Calibration
from avsec_gym.geometry import Floats
from avsec_gym.kitti.oxts import Oxts
from avsec_gym.kitti.oxts_poses import poses_from_oxts


def motion_from_oxts(oxts: Oxts, calibration: Calibration) -> Floats:
    """Poses of the rectified camera 0 on the ground plane.

    Args:
        oxts: Measurements of all frames.
        calibration: The calibration, with the place where the unit is mounted.

    Returns:
        x, y (m), heading (rad, without jumps) at every frame, shape (T, 3); the first is zero.

    Raises:
        ConfigurationError: The calibration does not hold where the unit is mounted.
    """
    if calibration.tr_imu_to_velo is None:
        raise ConfigurationError("the calibration has no Tr_imu_to_velo, which oxts need")
    to_velodyne = np.eye(4)
    to_velodyne[:3] = np.asarray(calibration.tr_imu_to_velo)[:3]
    to_unit = np.linalg.inv(calibration.velodyne_to_camera @ to_velodyne)
    camera = poses_from_oxts(oxts) @ to_unit
    # Cameras look along their z axis.
    forward = camera[:, :2, 2]
    headings = np.unwrap(np.arctan2(forward[:, 1], forward[:, 0]))
    return from_first(np.column_stack([camera[:, :2, 3], headings]))


def from_first(poses: Floats, first: int = 0) -> Floats:
    """Poses as they lie in the frame of one of them.

    Args:
        poses: x, y, heading, shape (T, 3).
        first: Row of the pose that becomes zero.
    """
    x, y, heading = poses[first]
    cos, sin = np.cos(heading), np.sin(heading)
    apart = poses[:, :2] - (x, y)
    return np.column_stack(
        [
            cos * apart[:, 0] + sin * apart[:, 1],
            cos * apart[:, 1] - sin * apart[:, 0],
            poses[:, 2] - heading,
        ]
    )
