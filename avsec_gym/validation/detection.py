"""Is one of three sensors attacked?  E_{0,1,2} against its threshold (thesis, section 3.3)."""

from __future__ import annotations

from collections.abc import Mapping

from avsec_gym.errors import ConfigurationError
from avsec_gym.sensor_system import LIDAR, SensorSystem, Triple
from avsec_gym.validation.evidence.disparity_error import DisparityError
from avsec_gym.validation.thresholds import Threshold

LIDAR_AND_TWO_CAMERAS = SensorSystem((LIDAR, 3, 2))
"""The thesis' scenario 1, KITTI's colour cameras."""


def detect_attack(
    errors: Mapping[Triple, DisparityError], thresholds: Mapping[Triple, Threshold]
) -> bool:
    """Whether one of the three sensors is attacked: E_{0,1,2} > theta_{0,1,2}.

    Args:
        errors: The errors of a frame of a three-sensor system, such as `DisparityErrors`.
        thresholds: The thresholds of the same system.

    Raises:
        ConfigurationError: More sensors; to find out which one is for `identify_attacked_sensors`.
    """
    if len(errors) != 1:
        raise ConfigurationError(
            f"detection looks at one triple of three sensors, got {len(errors)} triples"
        )
    (triple,) = errors
    return thresholds[triple].exceeded(errors[triple])
