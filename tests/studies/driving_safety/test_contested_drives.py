"""Contested drives: what a car sees matters in them."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from avsec_gym.closed_loop.loop_scenes import loop_scenes
from avsec_gym.drives import contested_drives as rule
from avsec_gym.drives.drive_row import DriveRow
from avsec_gym.drives.telling import by_scene
from avsec_gym.errors import DataError
from studies.driving_safety import contested_drives
from studies.driving_safety.closed_loop_film import most_telling

SCENES = {"source": "drives", "assets": "judge", "count": 4}


class Driven:
    """A drive that was made, of which only the end counts."""

    def __init__(self, **row: Any) -> None:
        self.row = row


def test_found_are_those_in_which_only_a_car_that_sees_drives_well(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Blind, the car is to blame in the second, third and fourth; seeing, it stops in the third."""

    class Setting:
        def __init__(self, name: str, arguments: dict[str, Any]) -> None:
            self.name = name

        def environment(self, scenarios: dict[str, Any]) -> Any:
            played = SimpleNamespace(scenes=loop_scenes(**scenarios))
            return SimpleNamespace(name=self.name, unwrapped=played)

    def drive(environment: Any, task: Any) -> Driven:
        number = int(task.scenario[-1])
        if environment.name == "blind":
            return Driven(at_fault=number > 0, outcome="collision")
        return Driven(at_fault=False, outcome="stopped" if number == 2 else "goal")

    monkeypatch.setattr(rule, "DriveSetting", Setting)
    monkeypatch.setattr(rule, "drive", drive)
    found = contested_drives.find_contested(SCENES, 2)
    assert (found.ids, found.looked_at) == (["drive-judge-000001", "drive-judge-000003"], 4)
    with pytest.raises(DataError, match="2 are contested"):
        contested_drives.find_contested(SCENES, 3)


def test_they_are_driven_by_avsec_drive_with_the_words_as_they_stand(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    file = tmp_path / "contested.json"
    called: list[list[str]] = []

    def run(words: list[str]) -> int:
        called.append(words)
        return 0

    file.write_text(json.dumps({"scenarios": SCENES, "ids": ["a", "b", "c"], "looked_at": 9}))
    monkeypatch.setattr(contested_drives, "run", run)
    words = ["--settings", "truth", '{"name": "x", "perception": "blind"}', "--out", "runs/x"]
    words += ["--resume", "--jobs", "2"]
    assert contested_drives.main(["drive", "--of", str(file), "--first", "2", *words]) == 0
    assert called == [["drive", "--scenarios", json.dumps(SCENES), "--ids", "a", "b", *words]]


def test_the_film_is_of_the_scene_in_which_the_attack_does_most() -> None:
    ends = {
        "a": ("goal", "goal", "goal"),
        "b": ("goal", "collision", "collision"),
        "c": ("goal", "collision", "goal"),
        "d": ("collision", "goal", "goal"),
    }
    rows: list[DriveRow] = [
        {"scenario": name, "intention": "straight", "outcome": end, "at_fault": end != "goal"}  # type: ignore[typeddict-item]
        for name, all_ends in ends.items()
        for end in all_ends
    ]
    assert most_telling(by_scene(rows)).scenario == "c"
