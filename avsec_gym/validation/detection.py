"""Is one of three sensors attacked?  E_{0,1,2} against its threshold (thesis, section 3.3)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from avsec_gym.errors import ConfigurationError
from avsec_gym.metrics.intervals import wilson_interval
from avsec_gym.sensor_system import LIDAR, SensorSystem, Triple
from avsec_gym.validation.disparity_error import DisparityError
from avsec_gym.validation.thresholds import Threshold

LIDAR_AND_TWO_CAMERAS = SensorSystem((LIDAR, 3, 2))
"""The thesis' scenario 1, KITTI's colour cameras."""
THREE_CAMERAS = SensorSystem((1, 3, 2))
"""Scenario 2, with KITTI's right grey camera; 1 and 3 stand 7 cm from each other, both half a
metre from 2."""


@dataclass(frozen=True)
class AlarmRate:
    """How often the alarm was raised: the detection rate of an attack, of clean frames a false one.

    Args:
        alarms: How many samples raised it.
        samples: Of how many.
    """

    alarms: int
    samples: int

    @property
    def rate(self) -> float | None:
        """The share; None without samples."""
        return self.alarms / self.samples if self.samples else None

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's 95 % interval; nan, nan without samples."""
        return wilson_interval(self.alarms, self.samples)


def detect_attack(
    errors: Mapping[Triple, DisparityError], thresholds: Mapping[Triple, Threshold]
) -> bool:
    """Whether one of the three sensors is attacked: E_{0,1,2} > theta_{0,1,2}.

    Args:
        errors: Of a moment of a three-sensor system, such as `DisparityErrors`.
        thresholds: Of the same system.

    Raises:
        ConfigurationError: More sensors; to find out which one is for `identify_attacked_sensors`.
    """
    if len(errors) != 1:
        raise ConfigurationError(
            f"detection looks at one triple of three sensors, got {len(errors)} triples"
        )
    (triple,) = errors
    return thresholds[triple].exceeded(errors[triple])


def alarm_rate(errors: Iterable[DisparityError], threshold: Threshold) -> AlarmRate:
    """How often a triple's errors exceed its threshold.

    Args:
        errors: E_{i,j,k} of many moments.
        threshold: Theta_{i,j,k}.
    """
    alarms = [threshold.exceeded(error) for error in errors]
    return AlarmRate(sum(alarms), len(alarms))
