"""The experiment on defences on walls of dots, and its tables on outcomes made by hand."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any, ClassVar

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.experiments.chapter3.defence.defended_episodes import (
    DefendedEpisodes,
    attacks_on,
    defence_cells,
    defence_inputs,
)
from avsec_gym.experiments.chapter3.defence.rates import alarm_rows, defence_rows
from avsec_gym.experiments.chapter3.defence.scenes import scene_of
from avsec_gym.experiments.chapter3.defence.validator import defending_validator
from avsec_gym.experiments.json_rows import as_json, row_json
from avsec_gym.kitti.raw import KittiRaw
from avsec_gym.kitti.tracklets import Tracklet, write_tracklets
from avsec_gym.metrics.safety import SafetyRecord
from avsec_gym.runs.experiment import Configuration, Measurement
from avsec_gym.sensor_system import KITTI_SYSTEM

NAN = float("nan")


@pytest.fixture(scope="module")
def configuration(
    tmp_path_factory: pytest.TempPathFactory, walls: ModuleType
) -> Iterable[Configuration]:
    root = tmp_path_factory.mktemp("drives")
    fit = walls.write_labelled_drives(root / "fit", 1, 12, first=5000)
    judged = walls.write_labelled_drives(root / "judged", 2, 2)
    with pytest.MonkeyPatch.context() as cache:
        cache.setenv("AVSEC_CACHE", str(root / "cache"))
        yield Configuration(str(judged), options={"fit": str(fit), "rate": 0.0})


def test_cells_and_inputs(configuration: Configuration) -> None:
    cells = defence_cells(configuration)
    assert len(cells) == 4 * 5
    assert [cell.arguments["attack"] for cell in cells[:5]] == ["none", "lidar", "1", "3", "2"]
    assert len({cell.group for cell in cells}) == 2
    assert attacks_on(KITTI_SYSTEM, 0) == ["none"]
    assert attacks_on(KITTI_SYSTEM, 2)[5] == "lidar+1"
    assert "validator" in defence_inputs(configuration)
    detectors = {**configuration.options, "detectors": "oracle,dsgn", "dsgn": "weights.bin"}
    inputs = defence_inputs(replace(configuration, options=detectors))
    assert inputs["weights of dsgn"] == Path("weights.bin")
    # What is fitted already needs no drives to fit on.
    fitted = {"fit": "nowhere", "fitted_file": "thresholds.json"}
    inputs = defence_inputs(replace(configuration, options=fitted))
    assert inputs == {"validator": Path("thresholds.json")}


def test_without_alarm_all_drive_alike_and_with_one_each_responds(
    configuration: Configuration,
) -> None:
    work = DefendedEpisodes(configuration)
    clean = work("none", 0)
    by_setting: dict[str, list[SafetyRecord]] = {}
    for row in clean.episodes:
        by_setting.setdefault(row.setting, []).append(row.record)
    responses = ("undefended", "stop", "drop", "repair")
    assert list(by_setting) == [
        f"{d} none {r}" for d in ("oracle", "lidar_oracle") for r in responses
    ]
    assert len({str([r.to_json() for r in records]) for records in by_setting.values()}) == 1
    assert {row.name: row.value for row in clean.measurements} == {
        "alarm": 0.0, "named lidar": 0.0, "named 1": 0.0, "named 3": 0.0, "named 2": 0.0,
    }  # fmt: skip
    blinded = work("2", 1)
    assert {row.value for row in blinded.measurements if row.name in ("alarm", "named 2")} == {1.0}
    reasons = {row.setting: row.record.reason for row in blinded.episodes}
    assert reasons["oracle 2 stop"] == reasons["lidar_oracle 2 stop"] == "stopped"
    assert "stopped" not in {reasons["oracle 2 drop"], reasons["oracle 2 repair"]}
    again = DefendedEpisodes(configuration)("2", 1)
    assert [r.record.to_json() for r in again.episodes] == [
        r.record.to_json() for r in blinded.episodes
    ]
    assert list(again.measurements) == list(blinded.measurements)


def test_an_attack_stays_as_it_is_over_a_drive(configuration: Configuration) -> None:
    work = DefendedEpisodes(configuration)
    frames = work._recordings.frames
    settings = [work._tampered("3", labelled.frame(), labelled.id).settings for labelled in frames]
    assert settings[0] == settings[1] != settings[2] == settings[3]


def test_what_a_frame_shows(
    configuration: Configuration, tmp_path: Path, walls: ModuleType
) -> None:
    drive = KittiRaw(configuration.scenarios).drive("0001")
    scene = scene_of(drive.frame(1), "a/1", 1, seed=3)
    assert (scene.id, scene.road_type, len(scene.boxes)) == ("a/1", "highway", 1)
    assert 11 <= scene.speeds[0] <= 13
    with pytest.raises(DataError, match="does not come from a drive"):
        scene_of(walls.wall(0), "1", 1)
    # A real drive has tracklets, or it is unknown.
    folder = (
        walls.write_labelled_drives(tmp_path, 1, 1) / "2026_01_01" / "2026_01_01_drive_0001_sync"
    )
    (folder / "label_02/data/0000000000.txt").unlink()
    frame = KittiRaw(tmp_path).drive("0001").frame(0)
    with pytest.raises(DataError, match="tracklet"):
        scene_of(frame, "0", 0)
    one = np.zeros((1, 3))
    car = Tracklet("Car", np.array([1.5, 1.6, 4.0]), 0, np.array([[12.0, 0, -1.7]]), one,
                   np.ones(1, int), np.zeros(1, int), np.zeros(1, int))  # fmt: skip
    write_tracklets(folder / "tracklet_labels.xml", [car])
    standing = scene_of(frame, "0", 0)
    assert (standing.road_type, standing.speeds.tolist()) == ("street", [0.0])


def test_a_validator_needs_what_it_was_fitted_to(configuration: Configuration) -> None:
    for options, complaint in (
        ({"validator": "likelihood"}, "needs a fit"),
        ({"validator": "dog"}, "thresholds or likelihood"),
    ):
        with pytest.raises(ConfigurationError, match=complaint):
            defending_validator(replace(configuration, options=options))
    assert defending_validator(configuration).system.sensors == ("lidar", 1, 3, 2)


def record(scenario: str, outcome: str, reason: str | None = None) -> SafetyRecord:
    return SafetyRecord(scenario, "straight", outcome, NAN, 1, NAN, NAN, reason)


class Stored:
    """Of four frames in two drives: what happened."""

    drives: ClassVar = {
        "oracle none undefended": "safe safe collision unplanned",
        "oracle none stop": "safe stopped collision unplanned",
        "oracle none drop": "safe safe collision unplanned",
        "oracle none repair": "safe safe collision unplanned",
        "oracle 2 undefended": "collision collision safe safe",
        "oracle 2 stop": "stopped crash stopped crash",
        "oracle 2 drop": "safe stopped collision safe",
        "oracle 2 repair": "safe safe safe safe",
    }
    frames = ("a/0", "a/1", "b/0", "b/1")
    alarms: ClassVar = {"none": (0, 1, 0, 0), "2": (0, 1, 0, 0), "3": (1, 1, 1, 1)}
    named: ClassVar = {
        "none": {"a/1": "1"},
        "2": {"a/1": "2"},
        "3": {"a/0": "3", "b/0": "3", "b/1": "1"},
    }

    def settings(self) -> list[tuple[str, float]]:
        return [(name, 0.0) for name in self.drives]

    def records(self, setting: str) -> list[SafetyRecord]:
        outcomes = {"stopped": ("unplanned", "stopped"), "crash": ("collision", "stopped")}
        return [
            record(id, *outcomes.get(word, (word,)))
            for id, word in zip(self.frames, self.drives[setting].split(), strict=True)
        ]

    def detections(self, setting: str, strength: float = 0.0) -> dict[str, Boxes3D]:
        return {}

    def measurements(self, **where: Any) -> list[Measurement]:
        rows = [
            Measurement(attack, id, "alarm", value)
            for attack, values in self.alarms.items()
            for id, value in zip(self.frames, values, strict=True)
        ]
        rows += [
            Measurement(attack, id, f"named {sensor}", 1.0)
            for attack, there in self.named.items()
            for id, sensor in there.items()
        ]
        return [row for row in rows if where.get("name", row.name) == row.name]


def counts(row: object, *names: str) -> list[tuple[int, int]]:
    shares = [getattr(row, name) for name in names]
    return [(share.count, share.of) for share in shares]


def test_collisions_avoided_and_false_stops() -> None:
    found = {(row.attack, row.response): row for row in defence_rows(Stored())}
    assert list(found)[::4] == [(attack, "undefended") for attack in ("none", "2", "any")]
    assert found["2", "undefended"].worth is None
    assert "avoided" not in row_json(found["2", "undefended"])
    rows = {case: row.worth for case, row in found.items()}
    worth = ("avoided", "caused", "given_up", "stopped")
    # Without attack the second frame is safe, and so is the first: both collide by the attack.
    assert counts(rows["2", "stop"], "avoided_of_attack") == [(1, 2)]
    assert counts(rows["none", "stop"], "avoided_of_attack") == [(0, 0)]
    assert counts(rows["none", "stop"], *worth) == [(0, 1), (0, 3), (1, 2), (1, 4)]
    assert counts(rows["2", "stop"], *worth) == [(1, 2), (1, 2), (1, 2), (4, 4)]
    assert counts(rows["2", "drop"], *worth) == [(2, 2), (1, 2), (0, 2), (1, 4)]
    # Two were safe before the attack and are not under it.
    regained = [
        counts(rows["2", response], "regained")[0] for response in ("stop", "drop", "repair")
    ]
    assert regained == [(0, 2), (1, 2), (2, 2)]
    assert counts(rows["none", "stop"], "regained") == [(0, 0)]
    assert counts(rows["any", "repair"], *worth) == [(2, 2), (0, 2), (0, 2), (0, 4)]
    assert found["2", "repair"].rates.safe_driving_rate == 1.0
    columns = row_json(found["2", "repair"])
    worth_of = found["2", "repair"].worth
    assert worth_of is not None
    assert (columns["safe_driving_rate"], worth_of.paired.safe_driving_rate.value) == (1.0, 0.5)
    assert columns["paired"] == as_json(worth_of.paired)
    assert found["2", "stop"].rates.safe_driving_rate == 0.0


def test_frames_to_alarm_and_who_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    rows = {row.attack: row for row in alarm_rows(Stored())}
    assert list(rows) == ["none", "2", "3"]
    assert "frames_to_alarm" not in row_json(rows["none"])
    assert rows["2"].frames_to_alarm == {"1": 1, "never": 1}
    assert rows["3"].frames_to_alarm == {"0": 2, "never": 0}
    assert counts(rows["none"], "alarms", "named_exactly") == [(1, 4), (3, 4)]
    # An alarm that names no sensor is none too many only where one was attacked.
    monkeypatch.setitem(Stored.named, "none", {})
    unnamed = {row.attack: row for row in alarm_rows(Stored())}["none"]
    assert counts(unnamed, "named_exactly") == [(3, 4)]
    assert counts(rows["2"], "alarms", "named_exactly") == [(1, 4), (1, 4)]
    assert counts(rows["3"], "alarms", "named_exactly") == [(4, 4), (2, 4)]
