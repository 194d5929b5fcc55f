"""The procedural drives in which it matters what a car sees, found by rule."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from avsec_gym.closed_loop.drive_record import Outcome
from avsec_gym.drives.one_drive import DriveTask, drive
from avsec_gym.drives.setting import DriveSetting


class ContestedRule:
    """Whether it matters in a scene what a car sees, that keeps its lane.

    A car that sees nothing is to blame for a collision, and one that knows the truth reaches its
    goal.  No detector is asked, so that the rule favours none.  It takes some 1.5 s of a processor
    for each scene.

    Args:
        scenarios: The procedural drives, as the environment takes them.
    """

    def __init__(self, scenarios: dict[str, Any]) -> None:
        self._blind, self._truth = (
            DriveSetting(name, {"perception": name}).environment(scenarios)
            for name in ("blind", "truth")
        )
        played: Any = self._blind.unwrapped
        self.scenes: tuple[str, ...] = tuple(map(str, played.scenes.ids))
        """The ids of all scenes."""

    def holds(self, scene: str) -> bool:
        """Whether a scene is contested.

        Raises:
            ConfigurationError: There is no such scene.
        """
        task = DriveTask("", scene, "straight", 0)
        is_blamed = drive(self._blind, task).row["at_fault"]
        return is_blamed and drive(self._truth, task).row["outcome"] == Outcome.GOAL


def contested_drives(scenarios: dict[str, Any]) -> Iterator[tuple[int, str]]:
    """The contested ones, each with the number of drives before it.

    Args:
        scenarios: The procedural drives, as the environment takes them.
    """
    rule = ContestedRule(scenarios)
    for number, scene in enumerate(rule.scenes):
        if rule.holds(scene):
            yield number, scene
