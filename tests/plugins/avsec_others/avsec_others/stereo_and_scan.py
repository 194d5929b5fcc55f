"""A validator of one error: do the stereo pair and the LiDAR see the same depths?"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from avsec_gym.frame import SensorFrame
from avsec_gym.sensor_system import LIDAR, SensorSystem
from avsec_gym.validation.evidence.disparity_error import DisparityErrors
from avsec_gym.validation.evidence.disparity_maps import DisparityMaps
from avsec_gym.validation.state_posterior import SensorStatus
from avsec_gym.validation.validator import Validation


@dataclass(frozen=True)
class StereoAndScan:
    """An alarm where too much of the scan contradicts the disparities of the cameras 3 and 2.

    One error shows that one of the three is attacked, and cannot tell which.

    Args:
        most: The share of contradicting pixels that raises no alarm, in [0, 1].
    """

    name: ClassVar[str] = "stereo_and_scan"
    system: ClassVar[SensorSystem] = SensorSystem((LIDAR, 3, 2))
    most: float = 0.3

    def validate(self, frame: SensorFrame) -> Validation:
        """Judge one frame."""
        errors = DisparityErrors(DisparityMaps(frame, self.system))
        alarm = errors[0, 1, 2].error > self.most
        status = SensorStatus.CANNOT_TELL if alarm else SensorStatus.SOUND
        return Validation(alarm, dict.fromkeys(self.system.sensors, status), errors)
