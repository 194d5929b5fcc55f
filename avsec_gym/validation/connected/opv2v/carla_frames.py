"""From CARLA's left-handed frames to ours.

CARLA's world and the frames of its sensors have x forward, y to the *right* and z up; angles are
degrees, yaw from x towards y (to the right), pitch up, roll right side down. OPV2V keeps a pose as
``[x, y, z, roll, yaw, pitch]``, and its point clouds in the frame of the sensor, left-handed, too
(OpenCOOD multiplies them by the matrix of the pose as they are). Our world is CARLA's with y turned
round, ``S = diag(1, -1, 1)``: a point becomes ``S p``, a transform ``S T S``, a yaw its negative.

Our velodyne frame is KITTI's, whose rays leave `TIP` above its origin; CARLA's leave the origin.
The velodyne frame of such a scan is therefore taken to lie `TIP` below the sensor.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from avsec_gym.frame import Points
from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.sweep import TIP

_MIRROR = np.diag([1.0, -1.0, 1.0, 1.0])


def velodyne_points(points: Points) -> Points:
    """Points of a CARLA sensor, shape (M, 4), in a velodyne frame `TIP` below it."""
    return np.asarray(points * [1.0, -1.0, 1.0, 1.0] + [0.0, 0.0, TIP, 0.0], np.float32)


def velodyne_pose(pose: Sequence[float] | Floats) -> Floats:
    """The pose of that velodyne frame in our world.

    Args:
        pose: x, y, z, roll, yaw, pitch of the sensor in CARLA's world, metres and degrees; or its
            transform, shape (4, 4), as `carla_transform` makes it.

    Returns:
        Shape (4, 4).

    Example:
        >>> velodyne_pose([1.0, 2.0, 3.165, 0.0, 90.0, 0.0]).round(6)[:3, 3].tolist()
        [1.0, -2.0, 3.0]
    """
    matrix = np.asarray(pose, np.float64)
    if matrix.shape != (4, 4):
        matrix = carla_transform(matrix)
    to_sensor = np.eye(4)
    to_sensor[2, 3] = -TIP
    return np.asarray(_MIRROR @ matrix @ _MIRROR @ to_sensor)


def carla_transform(pose: Sequence[float] | Floats) -> Floats:
    """The transform from a CARLA frame to CARLA's world, both left-handed, shape (4, 4).

    Args:
        pose: x, y, z, roll, yaw, pitch, metres and degrees.
    """
    x, y, z, *angles = pose
    roll, yaw, pitch = np.radians(angles)
    (c_r, c_y, c_p), (s_r, s_y, s_p) = np.cos([roll, yaw, pitch]), np.sin([roll, yaw, pitch])
    turned = np.array([[c_y, -s_y, 0], [s_y, c_y, 0], [0, 0, 1]])
    raised = np.array([[c_p, 0, -s_p], [0, 1, 0], [s_p, 0, c_p]])
    leaned = np.array([[1, 0, 0], [0, c_r, s_r], [0, -s_r, c_r]])
    matrix = np.eye(4)
    matrix[:3, :3] = turned @ raised @ leaned
    matrix[:3, 3] = x, y, z
    return matrix
