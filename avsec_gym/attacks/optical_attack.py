"""What an optical attack is: light that was not sent by the scene, into a camera or the LiDAR.

Unlike attacks on detectors it needs no victim: it knows neither networks nor labels.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from avsec_gym.attacks.attack import Seed
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.sensor_system import LIDAR, Sensor, sensor_name


@dataclass(frozen=True, eq=False)
class TamperedFrame:
    """A frame as the car gets it, and what was done to it; detectors see the frame alone.

    Args:
        frame: The frame, tampered with.
        pixels: Visibly changed pixels of each attacked camera, shape (H, W).
        points: Whether each point of the attacked scan is bogus, shape (M,); None: no attack on the
            LiDAR.
        lost: Whether each point of the clean scan is gone, shape (M of the clean scan,); None:
            none.
        settings: Drawn settings, such as ``radius``; scalars by name.
    """

    frame: SensorFrame
    pixels: Mapping[int, NDArray[np.bool_]] = field(default_factory=dict)
    points: NDArray[np.bool_] | None = None
    lost: NDArray[np.bool_] | None = None
    settings: Mapping[str, float] = field(default_factory=dict)

    @property
    def attacked(self) -> frozenset[Sensor]:
        """The sensors that were attacked."""
        lidar = () if self.points is None and self.lost is None else (LIDAR,)
        return frozenset((*self.pixels, *lidar))


@runtime_checkable
class OpticalAttack(Protocol):
    """An attack that shines light into sensors."""

    @property
    def name(self) -> str:
        """Name of the attack in results."""
        ...

    @property
    def sensors(self) -> frozenset[Sensor]:
        """The sensors that it attacks."""
        ...

    def attack(self, frame: SensorFrame, seed: Seed = 0) -> TamperedFrame:
        """The tampered frame; the same frame and seed give the same, in every process.

        Raises:
            DataError: The frame lacks a sensor that is to be attacked, or its file is broken.
        """
        ...


def check_attacked(attack: Any, there: Collection[Sensor], where: str) -> None:
    """Refuse an optical attack on sensors that are not there; attacks of other kinds pass.

    Args:
        attack: A live attack of any kind; None: no attack.
        there: The sensors.
        where: What has them, such as ``the scenes``.

    Raises:
        ConfigurationError: The attack is one on another sensor, too.
    """
    if isinstance(attack, OpticalAttack):
        check_there(f"the attack {attack.name!r}", attack.sensors, there, where)


def check_there(
    attack: str, attacked: frozenset[Sensor], there: Collection[Sensor], where: str
) -> None:
    """Refuse an attack on sensors that are not there.

    Args:
        attack: What errors call it.
        attacked: The sensors that it tampers with.
        there: The sensors that there are.
        where: What has them, such as ``the scenes``.

    Raises:
        ConfigurationError: It tampers with another sensor, too.
    """
    lacking = attacked - set(there)
    if lacking:
        named = " and ".join(sorted(map(sensor_name, lacking)))
        known = ", ".join(sorted(map(sensor_name, there))) or "no sensor"
        raise ConfigurationError(
            f"{attack} is one on {named}, but {where} have {known}: attack one of these"
        )
