"""Whether an adaptive attack breaks an entry, from what a run holds."""

from __future__ import annotations

from typing import Any

import pytest

from avsec_gym.benchmark.adaptive_rows import detection_row, detector_rows, validator_rows
from avsec_gym.boxes import Boxes3D
from avsec_gym.metrics.clustered_shares import share_of
from avsec_gym.metrics.safety import COLLISION, SAFE, SafetyRecord
from avsec_gym.runs.experiment import Measurement

SCENES = [f"{number:06d}" for number in range(40)]


class Kept:
    """The results of a run: of each setting, how many of the scenes are safe, and alarm."""

    def __init__(self, safe: dict[str, int], alarms: dict[str, int] | None = None) -> None:
        self.safe, self.alarms = safe, alarms or {}

    def settings(self) -> list[tuple[str, float]]:
        return [(name, 0.0) for name in self.safe]

    def records(self, **where: Any) -> list[SafetyRecord]:
        if where["setting"] not in self.safe:
            return []
        safe = self.safe[where["setting"]]
        return [
            SafetyRecord(id, "left", SAFE if n < safe else COLLISION, 1.0, 0, 1.0, 1.0)
            for n, id in enumerate(SCENES)
        ]

    def detections(self, setting: str, strength: float = 0.0) -> dict[str, Boxes3D]:
        return {}

    def measurements(self, **where: Any) -> list[Measurement]:
        alarms = self.alarms.get(where["setting"], 0)
        return [
            Measurement(where["setting"], id, where["name"], float(n < alarms))
            for n, id in enumerate(SCENES)
        ]


def test_a_detector_is_broken_by_what_does_better_than_every_listed_attack() -> None:
    listed = {"unattacked": 38, "transferred": 34, "patch": 30, "white_box": 24}
    [row] = detector_rows(Kept({**listed, "adaptive": 8}))
    assert (row.against, row.measure, row.breaks) == ("white_box", "safe", True)
    assert row.difference.value == pytest.approx(-16 / 40)
    # As good as the strongest, or better than all but one: what was listed still holds.
    for adaptive in (24, 23, 28):
        [row] = detector_rows(Kept({**listed, "adaptive": adaptive}))
        assert not row.breaks
    assert detector_rows(Kept(listed)) == []


def test_a_patch_is_of_another_budget_and_not_compared() -> None:
    [row] = detector_rows(Kept({"transferred": 34, "patch": 4, "white_box": 30, "adaptive": 8}))
    assert (row.against, row.breaks) == ("white_box", True)


def test_a_validator_is_broken_by_collisions_without_alarms() -> None:
    listed, under = "facula validated", "facula adaptive validated"
    [row] = validator_rows(Kept({listed: 40, under: 25}, {listed: 40, under: 10}))
    assert (row.setting, row.against, row.measure, row.breaks) == (under, listed, "collided", True)
    assert row.difference.value == pytest.approx(15 / 40)
    assert row.detected is not None
    assert (row.detected.count, row.detected.of) == (10, 40)
    # One scene in forty is what chance may bring.
    for safe in (40, 39):
        [row] = validator_rows(Kept({listed: 40, under: safe}, {listed: 40, under: 38}))
        assert not row.breaks
    assert validator_rows(Kept({listed: 40})) == []


@pytest.mark.parametrize(("lost", "breaks"), [(0, False), (1, False), (12, True)])
def test_a_validator_of_several_vehicles_by_detections(lost: int, breaks: bool) -> None:
    changed = [-1.0] * lost + [0.0] * (40 - lost)
    detected = share_of([True] * (40 - lost) + [False] * lost, SCENES)
    row = detection_row("ghost adaptive", "ghost", changed, SCENES, detected)
    assert row.breaks is breaks
    assert row.difference.value == pytest.approx(-lost / 40)
    assert detection_row("ghost adaptive", "ghost", [], [], share_of([], [])).breaks is False
