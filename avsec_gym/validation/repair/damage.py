"""Where the sensors that a validator names are damaged, as the sound sensors see it."""

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
    """The damage of one sensor.

    Args:
        pixels: The damaged pixels of a camera, shape (H, W).
        scan: The damage of a scan.
        unknown: Why the damage is unknown; empty where it is known.
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

    Two sound sensors, one of them a camera, check a camera; two sound cameras check the LiDAR.

    Args:
        validation: The result of a validator for one frame.
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
