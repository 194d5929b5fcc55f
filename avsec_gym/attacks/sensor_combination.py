"""Optical attacks on several sensors at once, as in the attack cases of the thesis (chapter 3)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from avsec_gym.argument_checks import camera_number, shown
from avsec_gym.attacks.attack import Seed
from avsec_gym.attacks.facula import Facula
from avsec_gym.attacks.lidar_spoofing import LidarSpoofing
from avsec_gym.attacks.optical_attack import OpticalAttack, TamperedFrame
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.sensor_system import LIDAR, Sensor, SensorSystem


@dataclass(frozen=True)
class SensorCombination:
    """Several optical attacks, each on sensors of its own.

    Each draws from a seed that its sensors are mixed into: what happens to a sensor depends on
    the seed and on its own attack alone, whichever others are attacked too.

    Args:
        attacks: Attacks in any order; none: the frame stays as it is.
        name: Name of the attack in results.

    Raises:
        ConfigurationError: Two attacks share a sensor.
    """

    attacks: tuple[OpticalAttack, ...]
    name: str = "sensor_combination"

    def __post_init__(self) -> None:
        object.__setattr__(self, "attacks", tuple(self.attacks))
        attacked = [sensor for attack in self.attacks for sensor in attack.sensors]
        if len(attacked) != len(set(attacked)):
            raise ConfigurationError(
                "each of the sensors is attacked once, got attacks on "
                + ", ".join(map(str, attacked))
            )

    @property
    def sensors(self) -> frozenset[Sensor]:
        """All that are attacked."""
        return frozenset(sensor for attack in self.attacks for sensor in attack.sensors)

    def attack(self, frame: SensorFrame, seed: Seed = 0) -> TamperedFrame:
        """The frame after all attacks; settings as ``camera_2_radius`` and ``lidar_distance``.

        See `OpticalAttack.attack`.
        """
        pixels: dict[int, NDArray[np.bool_]] = {}
        settings: dict[str, float] = {}
        points = lost = None
        for attack in self.attacks:
            tampered = attack.attack(frame, _own_seed(seed, attack.sensors))
            frame = tampered.frame
            pixels.update(tampered.pixels)
            if LIDAR in attack.sensors:
                points, lost = tampered.points, tampered.lost
            place = "_".join(_label(sensor) for sensor in sorted(attack.sensors, key=str))
            settings.update({f"{place}_{key}": value for key, value in tampered.settings.items()})
        return TamperedFrame(frame, pixels, points, lost, settings)


def thesis_attack(sensors: Iterable[Sensor], reference: int = 2) -> SensorCombination:
    """The thesis' attack on each of these sensors: a facula on a camera, a bogus return on a LiDAR.

    Args:
        sensors: Cameras' numbers and `LIDAR`.
        reference: The camera in whose view the bogus return is.

    Raises:
        ConfigurationError: Something else than sensors, or one of them twice.

    Example:
        >>> [sorted(thesis_attack(case).sensors, key=str) for case in [("lidar", 3), (2,)]]
        [[3, 'lidar'], [2]]
    """
    array = isinstance(sensors, np.ndarray) and sensors.ndim != 1
    if array or isinstance(sensors, str | Mapping) or not isinstance(sensors, Iterable):
        raise ConfigurationError(
            f"sensors takes cameras' numbers and {LIDAR!r}, such as [2, {LIDAR!r}], got "
            f"{shown(sensors)}"
        )
    camera_number("reference", reference)
    attacks: list[OpticalAttack] = [
        LidarSpoofing(reference=reference) if _is_lidar(sensor) else Facula(_camera(sensor))
        for sensor in sensors
    ]
    return SensorCombination(tuple(attacks), name="thesis")


def attack_cases(system: SensorSystem, most: int | None = None) -> tuple[tuple[Sensor, ...], ...]:
    """Every set of sensors that an attacker can choose, the smaller ones first.

    Args:
        system: The sensor system, whose sensors are attacked.
        most: Attacked at once; None: all of them.

    Example:
        >>> len(attack_cases(SensorSystem(("lidar", 3, 2))))
        7
    """
    sizes = range(1, (len(system) if most is None else most) + 1)
    return tuple(case for size in sizes for case in combinations(system.sensors, size))


def _camera(sensor: Sensor) -> int:
    try:
        return camera_number("a sensor", sensor)
    except ConfigurationError:
        raise ConfigurationError(
            f"sensors takes cameras' numbers and {LIDAR!r}, got {shown(sensor)} among them"
        ) from None


def _is_lidar(sensor: Sensor) -> bool:
    return isinstance(sensor, str) and sensor == LIDAR


def _label(sensor: Sensor) -> str:
    return LIDAR if sensor == LIDAR else f"camera_{sensor}"


def _own_seed(seed: Seed, sensors: frozenset[Sensor]) -> list[int]:
    # Never 0: numpy's seeds [5] and [5, 0] are the same.
    numbers = sorted(1 if sensor == LIDAR else _camera(sensor) + 2 for sensor in sensors)
    return [*([seed] if isinstance(seed, int) else seed), *numbers]
