"""The procedural drives in which it matters what a car sees, found by rule."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from avsec_gym.closed_loop.drive_record import Outcome
from avsec_gym.drives.one_drive import DriveTask, drive
from avsec_gym.drives.setting import DriveSetting


def contested_drives(scenarios: dict[str, Any]) -> Iterator[tuple[int, str]]:
    """The contested ones, each with the number of drives before it.

    A drive straight on is contested if a car that sees nothing is to blame for a collision there,
    and one that knows the truth reaches its goal.  No detector is asked, so that the rule favours
    none.  It takes some 1.5 s of a processor for each drive.

    Args:
        scenarios: The procedural drives, as the environment takes them.
    """
    blind, truth = (
        DriveSetting(name, {"perception": name}).environment(scenarios)
        for name in ("blind", "truth")
    )
    scenes: Any = blind.unwrapped
    for number, scene in enumerate(scenes.scenes.ids):
        task = DriveTask("", scene, "straight", number)
        is_blamed = drive(blind, task).row["at_fault"]
        if is_blamed and drive(truth, task).row["outcome"] == Outcome.GOAL:
            yield number, str(scene)
