"""A spoofed scan: bogus LiDAR returns of a plane that seems to stand on the road as one drives."""

from __future__ import annotations

import math

import numpy as np

from avsec_gym.argument_checks import number_range
from avsec_gym.attacks.lidar_spoofing import LidarSpoofing
from avsec_gym.closed_loop.attack.drive_attack import DriveAttack
from avsec_gym.closed_loop.relative_poses import in_world, seen_from
from avsec_gym.closed_loop.surroundings import Surroundings
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats, ego_to_camera, transform_points
from avsec_gym.rig import SensorRig
from avsec_gym.sensor_system import LIDAR

_FARTHEST = 50.0
_NEAREST = 1.0
"""Metres from the LiDAR below which it is not spoofed: the car has driven through the plane."""


class SpoofedScan(DriveAttack):
    """An upright plane of bogus points at one place in the world, which faces the LiDAR.

    An action has five numbers: above 0, the plane is up; where it is laid, ahead and left; its
    width and its height.  A plane that is up already stays at its place, and as large as it was
    laid; to move it, the attacker takes it down and lays it anew.  All is scaled linearly.  The
    energy of a frame is the plane's area, as a share of the largest.

    Args:
        ahead: Metres ahead of the car, the first and the last, from 1 to 100.
        left: Metres to its left, the first and the last, within 20.
        widths: The smallest and the largest width, metres, from 0.01 to 50.
        heights: The smallest and the largest height, metres, from 0.01 to 10.

    Raises:
        ConfigurationError: A number is out of range.
    """

    action_size, state_size, sensors = 5, 5, frozenset({LIDAR})

    def __init__(
        self,
        ahead: tuple[float, float] = (5.0, 40.0),
        left: tuple[float, float] = (-8.0, 8.0),
        widths: tuple[float, float] = (0.5, 2.5),
        heights: tuple[float, float] = (0.5, 1.5),
    ) -> None:
        spans = (
            number_range("ahead", ahead, 1.0, 100.0),
            number_range("left", left, -20.0, 20.0),
            number_range("widths", widths, 0.01, 50.0),
            number_range("heights", heights, 0.01, 10.0),
        )
        self._low, self._high = np.array(spans).T
        self.begin()

    def begin(self) -> None:
        """No plane."""
        self._place: Floats | None = None
        self._width = self._height = 0.0

    def act(self, action: Floats, around: Surroundings) -> float:
        """Lay the plane, keep it up, or take it down."""
        if action[0] <= 0:
            self.begin()
            return 0.0
        if self._place is None:
            scaled = self._low + 0.5 * (action[1:] + 1.0) * (self._high - self._low)
            ahead, left, self._width, self._height = scaled.tolist()
            [self._place] = in_world(around.pose, np.array([[ahead, left, 0.0]]))
        return float(self._width * self._height / np.prod(self._high[2:]))

    def state(self, around: Surroundings) -> Floats:
        """Up; ahead and left / 50 m in the car's frame; width and height as shares of the largest.

        Zeros where it is down.
        """
        if self._place is None:
            return np.zeros(self.state_size)
        [(x, y, _)] = seen_from(around.pose, self._place[None])
        size = np.array([self._width, self._height]) / self._high[2:]
        return np.array([1.0, x / _FARTHEST, y / _FARTHEST, *size])

    @property
    def facts(self) -> dict[str, float]:
        """`width` and `height` of the plane, metres; 0 where there is none."""
        return {"width": self._width, "height": self._height}

    def tampered(self, frame: SensorFrame, around: Surroundings) -> SensorFrame:
        """The frame with the bogus points in its scan, where it has one."""
        if self._place is None or not frame.has_points:
            return frame
        # From the camera, which stands at the car's centre, to the LiDAR; both look level.
        rig = SensorRig(frame.calibration)
        foot, _ = ego_to_camera(seen_from(around.pose, self._place[None]), 0.0)
        [place] = transform_points(rig.camera_to_vehicle, foot)
        x, y, _ = (place - rig.velodyne_pose[:3, 3]).tolist()
        distance = math.hypot(x, y)
        if distance < _NEAREST:
            return frame
        spoofing = LidarSpoofing(self._width, self._height, distance, math.atan2(y, x))
        return spoofing.attack(frame, round(1000 * around.time)).frame
