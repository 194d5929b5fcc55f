"""Which drives are worth a look: scenes in which the settings end otherwise come first."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from avsec_gym.closed_loop.drive_record import Outcome
from avsec_gym.drives.drive_row import DriveRow

_WORDS = {Outcome.OFF_ROAD: "left the road", Outcome.TIME: "time over"}
_HOW_BAD = {Outcome.OFF_ROAD: 3, Outcome.COLLISION: 2, Outcome.GOAL: 0}
_AT_FAULT = 4


@dataclass(frozen=True)
class DrivenScene:
    """The drives of one scene and intention.

    Args:
        scenario: The scene's id.
        intention: Where the car wanted to go.
        rows: A drive for each setting, in the order of the settings.
    """

    scenario: str
    intention: str
    rows: tuple[DriveRow, ...]

    @property
    def worst(self) -> int:
        """How badly the worst of its drives ended; 0: all reached the goal."""
        return max(map(how_bad, self.rows))

    @property
    def contrast(self) -> int:
        """How much worse one setting ended than another."""
        return self.worst - min(map(how_bad, self.rows))


def outcome_in_words(row: DriveRow) -> str:
    """How a drive ended.

    Example:
        >>> outcome_in_words({"outcome": "collision", "at_fault": True})
        'collision, at fault'
    """
    outcome = Outcome(row["outcome"])
    if outcome == Outcome.COLLISION:
        return "collision, at fault" if row["at_fault"] else "collision, not at fault"
    return _WORDS.get(outcome, str(outcome))


def how_bad(row: DriveRow) -> int:
    """How bad an end is, from 0, the goal, to 4, a collision that the car is to blame for."""
    return _AT_FAULT if row["at_fault"] else _HOW_BAD.get(row["outcome"], 1)


def by_scene(rows: Iterable[DriveRow]) -> list[DrivenScene]:
    """The drives by scene and intention, in the order of the first of each."""
    found: dict[tuple[str, str], list[DriveRow]] = {}
    for row in rows:
        found.setdefault((row["scenario"], row["intention"]), []).append(row)
    return [DrivenScene(*key, tuple(own)) for key, own in found.items()]


def telling(scenes: Iterable[DrivenScene]) -> list[DrivenScene]:
    """Scenes with a drive that ended badly, the greatest contrast between settings first."""
    bad = [scene for scene in scenes if scene.worst > 0]
    return sorted(bad, key=lambda scene: (-scene.contrast, -scene.worst))


def good(scenes: Iterable[DrivenScene]) -> list[DrivenScene]:
    """Scenes in which every drive reached its goal, those with the smallest distances first."""
    fine = [scene for scene in scenes if scene.worst == 0]
    return sorted(fine, key=_nearest)


def _nearest(scene: DrivenScene) -> float:
    known = [row["smallest_distance"] for row in scene.rows]
    return min((each for each in known if each is not None), default=float("inf"))
