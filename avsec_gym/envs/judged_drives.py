"""Drives that an attacker is measured against: each is driven once, when it is first asked for."""

from __future__ import annotations

import zlib
from typing import Any

from avsec_gym.closed_loop.drive_record import DriveRecord, Outcome
from avsec_gym.envs.drivers import Driver
from avsec_gym.scenario.intention import Intention


class JudgedDrives:
    """Drives of one car by one driver, without the attack.

    Args:
        drive: The environment, with the car's perception in it.
        driver: The driver of the car.
    """

    def __init__(self, drive: Any, driver: Driver) -> None:
        self._drive, self._driver = drive, driver
        self._records: dict[tuple[str, Intention], DriveRecord] = {}

    def record(self, scenario: str, intention: Intention) -> DriveRecord:
        """What becomes of the drive.

        Args:
            scenario: Id of the scene.
            intention: Where the car wants to go.
        """
        key = scenario, intention
        if key not in self._records:
            options = {"scenario": scenario, "intention": str(intention)}
            seen, _ = self._drive.reset(seed=seed_of(scenario, intention), options=options)
            while self._drive.record is None:
                action, _ = self._driver.predict(seen, deterministic=True)
                seen, *_ = self._drive.step(action)
            self._records[key] = self._drive.record
        return self._records[key]


def is_safe(record: DriveRecord) -> bool:
    """Whether the car reached its goal, and touched nothing."""
    return record.outcome == Outcome.GOAL


def is_to_blame(record: DriveRecord) -> bool:
    """Whether the car collided by its own fault, or left the road."""
    return record.at_fault or record.outcome == Outcome.OFF_ROAD


def seed_of(scenario: str, intention: Intention) -> int:
    """The seed of all that is left to chance in a drive, with and without an attack.

    So an attacked drive differs from the unattacked one by nothing but the attack.
    """
    return zlib.crc32(f"{scenario} {intention}".encode())
