"""Where the sensors that a validator names are damaged, as those see it that are sound."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from avsec_gym.errors import ConfigurationError
from avsec_gym.sensor_system import LIDAR, Sensor
from avsec_gym.validation.evidence.reprojection import Mask
from avsec_gym.validation.repair.damaged_scan import DamagedScan, damaged_scan
from avsec_gym.validation.repair.localisation import damaged_pixels
from avsec_gym.validation.state_posterior import SensorStatus
from avsec_gym.validation.validator import Validation


@dataclass(frozen=True, eq=False)
class Damage:
    """Of one sensor.

    Args:
        pixels: Of a camera, shape (H, W).
        scan: Of a LiDAR.
        unknown: Why it cannot be told; empty where it can.
    """

    pixels: Mask | None = None
    scan: DamagedScan | None = None
    unknown: str = ""

    @property
    def row(self) -> dict[str, Any]:
        """How much it is; JSON-able."""
        if self.pixels is not None:
            return {"share_of_pixels": round(float(self.pixels.mean()), 6)}
        if self.scan is not None:
            counts = {"points": self.scan.points, "lost_directions": self.scan.lost}
            return {name: int(mask.sum()) for name, mask in counts.items()}
        return {"unknown": self.unknown}


def located_damage(validation: Validation) -> dict[Sensor, Damage]:
    """The damage in each sensor that is named; none without an alarm.

    It takes two sound sensors to look at a camera, one of them a camera; two cameras for the LiDAR.

    Args:
        validation: Of a frame.
    """
    sensors = validation.errors.maps.system.sensors
    return {
        sensor: _damage(validation, sensor) for sensor in sensors if sensor in validation.attacked
    }


def _damage(validation: Validation, sensor: Sensor) -> Damage:
    maps = validation.errors.maps
    known = validation.statuses.items()
    sound = [sensor for sensor, status in known if status == SensorStatus.SOUND]
    try:
        if sensor == LIDAR:
            return Damage(scan=damaged_scan(maps.frame, sound, maps.depth))
        return Damage(pixels=damaged_pixels(maps.frame, int(sensor), sound, maps.depth))
    except ConfigurationError as error:
        return Damage(unknown=str(error))
