"""The scene that the demo drives on in: found by rule, and what the search has passed over.

A scene is contested if a car that sees nothing is to blame for a collision there and one that sees
all reaches its goal.  It is telling if, beyond that, the light decides what becomes of the car with
the detector.  Looking for a telling one takes long: of the demo's own seed it is known (`TELLING`),
of other seeds the first contested one is taken.
"""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from avsec_gym.drives.contested_drives import contested_drives
from avsec_gym.drives.drive_row import DriveRow
from avsec_gym.drives.one_drive import DriveTask, drive
from avsec_gym.drives.setting import DriveSetting
from avsec_gym.errors import DataError

STRAIGHT = "straight"
"""The demo's car keeps its lane."""
MOST_SCENES = 1000
"""How many procedural drives are looked at; some four in a hundred are contested."""
_LOG = logging.getLogger(__name__)


@dataclass(frozen=True)
class PassedOver:
    """The scenes that a search looked at before the one that it found.

    Args:
        scenes: The number of all of them.
        missed_goal: Contested ones in which the unattacked car does not reach its goal.
        harmless: Contested ones in which it does, and the attacked car is not to blame for a
            collision.
    """

    scenes: int
    missed_goal: int = 0
    harmless: int = 0

    @property
    def contested(self) -> int:
        """How many of the scenes are contested."""
        return self.missed_goal + self.harmless

    def in_words(self) -> str:
        """A sentence.

        Example:
            >>> PassedOver(30, missed_goal=2, harmless=1).in_words().partition(": in ")[0]
            'Passed over before it: 30 scenes, 3 of them contested'
        """
        return (
            f"Passed over before it: {self.scenes} scenes, {self.contested} of them contested:"
            f" in {self.missed_goal} the unattacked car misses its goal,"
            f" in {self.harmless} the light leads to no collision that the car is to blame for."
        )


@dataclass(frozen=True)
class TellingDrive:
    """A telling scene.

    Args:
        scene: The id of the scene.
        passed_over: What the search looked at before it; None: not known.
    """

    scene: str
    passed_over: PassedOver | None = None


TELLING = {0: TellingDrive("drive-000181", PassedOver(181, missed_goal=2, harmless=2))}
"""What `telling_drive` finds, by the demo's seed."""


def contested_drive(scenarios: dict[str, Any]) -> str:
    """The first contested scene.

    Args:
        scenarios: The procedural drives, as the environment takes them.

    Raises:
        DataError: None of the scenes is such a one.
    """
    for _, scene in contested_drives(scenarios):
        return scene
    raise DataError(
        f"of {scenarios['count']} procedural drives, none is contested.",
        remedy="Take another --seed.",
    )


def telling_drive(
    scenarios: dict[str, Any], seed: int, unattacked: DriveSetting, attacked: DriveSetting
) -> TellingDrive:
    """The first contested scene in which the car reaches its goal, and under the laser collides.

    Args:
        scenarios: The procedural drives, as the environment takes them.
        seed: The demo's seed.
        unattacked: The car with the detector.
        attacked: The same car under the laser.

    Raises:
        DataError: None of the scenes is such a one.
    """
    environments = [(each.name, each.environment(scenarios)) for each in (unattacked, attacked)]
    failed: Counter[str] = Counter()
    for number, scene in contested_drives(scenarios):
        ends = (
            drive(environment, DriveTask(name, scene, STRAIGHT, seed)).row
            for name, environment in environments
        )
        failure = _failure(ends)
        if not failure:
            return TellingDrive(scene, PassedOver(number, **failed))
        failed[failure] += 1
        _LOG.info("%s is passed over: %s", scene, failure)
    raise DataError(
        f"of {scenarios['count']} procedural drives, the light decides none.",
        remedy="Take another --seed.",
    )


def _failure(ends: Iterator[Any]) -> str:
    """The count of `PassedOver` that a contested scene belongs to; empty: the scene is telling.

    Args:
        ends: The rows of both drives; the attacked one is made only if it is asked for.
    """
    unattacked: DriveRow = next(ends)
    if unattacked["outcome"] != "goal":
        return "missed_goal"
    return "" if next(ends)["at_fault"] else "harmless"
