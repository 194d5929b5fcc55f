"""Entries: the same rows whenever they are made, and those that the pipeline gives."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from avsec_gym.attacks.attack import Budget, Seed, Victim
from avsec_gym.benchmark import adaptive_rows, loop_drives, protocol, query_rows
from avsec_gym.benchmark.entry import read_entry
from avsec_gym.benchmark.frames import write_frames
from avsec_gym.benchmark.making import entered
from avsec_gym.benchmark.protocol import Entered
from avsec_gym.benchmark.scene_sets import FrozenSet
from avsec_gym.boxes import Boxes3D
from avsec_gym.closed_loop.error_model.model import ErrorModel, write_error_model
from avsec_gym.drives.one_drive import DriveTask, drive
from avsec_gym.drives.setting import DriveSetting
from avsec_gym.drives.summary import Mean
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.experiments.json_rows import row_json
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.kitti.labels import read_labels, write_detections
from avsec_gym.metrics.estimate import Estimate
from avsec_gym.metrics.paired import paired_differences
from avsec_gym.metrics.safety import SafetyRates
from avsec_gym.perception.detectors.boxes_in_view import boxes_in_view
from avsec_gym.pipeline import run_episode
from avsec_gym.planners.planner import Algorithm, MotionPrimitivePlanner
from avsec_gym.registry import Kind, names, register
from avsec_gym.scenario.intention import Intention
from avsec_gym.sensor_system import LIDAR, SensorSystem
from avsec_gym.validation.state_posterior import SensorStatus
from avsec_gym.validation.validator import Validation


def made(kind: str, part: Any, root: Path, **more: Any) -> Any:
    return entered(Entered(kind), part, root, workers=0, **more)


def test_a_planner(few: dict[str, FrozenSet], tmp_path: Path) -> None:
    entry = made("planner", "gbfs", tmp_path / "one")
    assert [(row.scenes, row.setting) for row in entry.rows] == [
        ("all", "truth"), ("contested", "truth"),
    ]  # fmt: skip
    ways = few["contested"].layouts().intentions
    assert ways is not None
    assert [row.rates.scenarios for row in entry.rows] == [6, len(*ways.values())]
    planner = MotionPrimitivePlanner(Algorithm.GBFS)
    scenes = few["all"].layouts().labelled
    records = [run_episode(s, way, planner=planner).record for s in scenes for way in Intention]
    expected = SafetyRates.of(records).to_json()
    found = entry.rows[0].rates.to_json()
    assert {name: found[name] for name in ("planned", "collisions", "failures")} == {
        name: expected[name] for name in ("planned", "collisions", "failures")
    }
    assert (
        found["safe_driving_rate_interval"]
        == (SafetyRates.of(records).to_json()["safe_driving_rate_interval"])
    )
    # Made anew it is the same; gone on with, nothing is driven again.
    again = made("planner", "gbfs", tmp_path / "two")
    assert again.to_json() == entry.to_json() == made("planner", "gbfs", tmp_path / "one").to_json()
    assert read_entry(tmp_path / "one" / "entry.json").to_json() == entry.to_json()
    assert made("planner", "gbfs", tmp_path / "quick", quick=True).rows[0].rates.scenarios == 3


def test_a_planner_drives_on_as_avsec_drive_has_it(
    few: dict[str, FrozenSet], tmp_path: Path
) -> None:
    entry = made("planner", "astar", tmp_path / "one")
    drives = loop_drives.frozen_drives()
    truth, errors = entry.drives
    assert (truth.setting, errors.setting, errors.against) == ("truth", "dsgn", "truth")
    assert truth.goal.count == truth.goal.of == sum(map(len, drives.ways.values()))
    assert (truth.at_fault.count, truth.scenes) == (0, 2)
    perception = {"name": "error_model", "model": str(drives.error_models["dsgn"])}
    car = DriveSetting("dsgn", {"perception": perception}).environment(drives.scenes)
    rows = [
        drive(car, DriveTask("dsgn", id, str(way), drives.number(id, way))).row
        for id, ways in drives.ways.items()
        for way in ways
    ]
    assert errors.at_fault.count == sum(row["at_fault"] for row in rows)
    assert errors.goal.count == sum(row["outcome"] == "goal" for row in rows)
    scores = np.mean([row["navsim_score"] for row in rows])
    assert errors.navsim_score.value == pytest.approx(scores)
    assert truth.navsim_score.value is not None
    assert errors.navsim_difference is not None
    assert errors.navsim_difference.value == pytest.approx(scores - truth.navsim_score.value)
    assert made("planner", "astar", tmp_path / "two").to_json() == entry.to_json()
    again = read_entry(tmp_path / "one" / "entry.json").drive("dsgn")
    assert again is not None
    assert row_json(again) == row_json(errors)


@pytest.mark.slow
def test_a_detector_drives_on_by_its_error_models(
    few: dict[str, FrozenSet], tmp_path: Path
) -> None:
    """Sure sight and blindness as error models: what makes the drives contested ones."""
    sure = ErrorModel(card={"detector": "oracle", "attack": ""})
    blind = replace(
        sure, found=(-50.0, *sure.found[1:]), card={"detector": "oracle", "attack": "curtain"}
    )
    files = [str(tmp_path / "sure.json"), str(tmp_path / "blind.json")]
    for path, model in zip(files, (sure, blind), strict=True):
        write_error_model(path, model)
    entry = made("detector", "oracle", tmp_path / "out", error_models=files)
    seeing, dark = entry.drives
    assert (seeing.setting, dark.setting, dark.attack) == ("unattacked", "curtain", "curtain")
    assert (seeing.at_fault.count, dark.goal.count) == (0, 0)
    assert seeing.goal.count == seeing.goal.of
    assert dark.at_fault.count + dark.off_road.count == dark.goal.of
    assert entry.skipped == {}
    assert [row.scenes for row in entry.scenes] == ["all", "contested", "closed_loop"]
    assert str(tmp_path) not in json.dumps(entry.to_json())
    with pytest.raises(DataError):
        made("detector", "oracle", tmp_path / "out", error_models=files[:1])


@pytest.mark.slow
def test_a_detector_that_sees_all_and_one_that_sees_nothing(
    few: dict[str, FrozenSet], tmp_path: Path
) -> None:
    seeing = made("detector", "oracle", tmp_path / "seeing")
    assert [row.setting for row in seeing.rows[:3]] == ["unattacked", "transferred", "patch"]
    first = seeing.rows[0]
    assert first.precision is not None
    assert first.precision.strict.value == pytest.approx(first.precision.ceiling)
    assert seeing.white_box is False
    assert not seeing.masked
    assert seeing.weights == {}
    assert not seeing.drives
    assert "--error-model" in seeing.skipped["closed_loop"]
    assert seeing.rows[1].paired is not None
    assert seeing.rows[1].paired.safe_driving_rate.value == 0.0
    # That is what makes the scene a contested one.
    blind = made("detector", nothing_seen(tmp_path / "nothing", few), tmp_path / "blind")
    rates = {row.scenes: row.rates.safe_driving_rate for row in blind.rows}
    assert rates["contested"] == 0.0
    assert seeing.row("contested", "unattacked").rates.safe_driving_rate == 1.0


def nothing_seen(folder: Path, sets: dict[str, FrozenSet]) -> dict[str, str]:
    """A folder of results in which nothing is seen."""
    for name, frozen in sets.items():
        for id in frozen.ids():
            write_detections(folder / name / "unattacked" / f"{id}.txt", Boxes3D.empty())
    return {"name": "replayed", "detections": str(folder)}


@pytest.mark.slow
def test_frames_for_a_foreign_detector_lead_to_the_entry_of_one_by_name(
    few: dict[str, FrozenSet], tmp_path: Path
) -> None:
    class Dark:
        """Sees what is dark: it depends on pixels, and is not known here by its gradients."""

        name = "dark"

        def detect(self, frame: SensorFrame) -> Boxes3D:
            return found_in(frame)

    if "dark" not in names(Kind.DETECTOR):
        register(Kind.DETECTOR, "dark", Dark)
    steps = []
    folders = write_frames(tmp_path / "frames", on_progress=lambda *step: steps.append(step))
    assert steps[-1] == (9, 9)
    assert len(folders) == 6
    for folder in folders:
        results = tmp_path / "results" / folder.relative_to(tmp_path / "frames")
        data = KittiObject(folder)
        for id in data.ids(having=("image_2", "image_3", "calib", "velodyne")):
            write_detections(results / f"{id}.txt", found_in(data.frame(id)))
    stamps = {path: path.stat().st_mtime_ns for path in (tmp_path / "frames").rglob("*.png")}
    write_frames(tmp_path / "frames")
    assert {path: path.stat().st_mtime_ns for path in stamps} == stamps
    part = {"name": "replayed", "detections": str(tmp_path / "results")}
    foreign = made("detector", part, tmp_path / "foreign", name="dark")
    own = made("detector", "dark", tmp_path / "own")
    own_rows, foreign_rows = own.to_json()["rows"], foreign.to_json()["rows"]
    settings = {"unattacked", "transferred", "patch"}
    assert {row["setting"] for row in own_rows} == {*settings, "adaptive"}
    # Who has the results alone cannot ask the detector which attack harms it most.
    assert foreign_rows == [row for row in own_rows if row["setting"] in settings]
    assert (foreign.broken, own.broken) == (None, False)
    assert str(tmp_path) not in json.dumps(foreign.to_json())


def found_in(frame: SensorFrame) -> Boxes3D:
    """A car at a distance that hangs on the image, in whole centimetres, as files have it."""
    distance = 8.0 + round(float(frame.image(2).mean()) % 10, 2)
    location = np.array([[0.0, 1.65, distance]])
    size, turn, score = np.array([[1.5, 1.6, 4.0]]), np.array([-1.57]), np.array([0.9])
    return boxes_in_view(location, size, turn, score, "Car", frame.calibration, (120, 320))


def test_results_are_there_for_every_frame(few: dict[str, FrozenSet], tmp_path: Path) -> None:
    part = nothing_seen(tmp_path / "results", few)
    last = few["contested"].ids()[-1]
    (tmp_path / "results/contested/unattacked" / f"{last}.txt").unlink()
    with pytest.raises(DataError, match=f"1 of 1 result files .* {last}.txt"):
        made("detector", part, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_what_was_entered_stays_what_it_is(few: dict[str, FrozenSet], tmp_path: Path) -> None:
    """Neither another part nor other results go on in a folder."""
    part = nothing_seen(tmp_path / "results", few)
    made("detector", part, tmp_path / "out")
    with pytest.raises(DataError):
        made("detector", "oracle", tmp_path / "out")
    with pytest.raises(DataError):
        made("detector", part, tmp_path / "out", quick=True)
    id = few["all"].ids()[0]
    path = tmp_path / "results" / "all" / "unattacked" / f"{id}.txt"
    path.write_text("Car 0 0 0 0 0 50 50 1.5 1.6 4.0 0 1.65 20 0 0.9\n")
    with pytest.raises(DataError):
        made("detector", part, tmp_path / "out")


def truth_of(frame: SensorFrame) -> Boxes3D:
    assert frame.origin is not None
    return read_labels(frame.origin / "label_2" / f"{frame.id}.txt")


def change_of(frame: SensorFrame) -> Any:
    """The largest change of each pixel of the left image, grey levels."""
    assert frame.origin is not None
    there = KittiObject(frame.origin.parent).frame(frame.id)
    return np.abs(np.subtract(frame.image(2), there.image(2), dtype=float)).max(axis=2)


def certain_differences(first: Any, second: Any) -> Any:
    """One scene has no interval: the difference itself decides."""
    found = paired_differences(first, second)
    assert found is not None
    value = found.safe_driving_rate.value
    assert value is not None
    return replace(found, safe_driving_rate=Estimate(value, (value, value)))


class Fooled:
    """Gives gradients, and sees nothing under one of the attacks."""

    name = "fooled"

    def __init__(self, under: str) -> None:
        self.under = under

    def detect(self, frame: SensorFrame) -> Boxes3D:
        # What changes few pixels much, and what changes many of them a little, see `Towards`.
        change = change_of(frame)
        many = (change > 0).mean() > 0.5
        attack = {
            "patch": not many and change.max() > 30,
            "white_box": many and change.max() < 6,
            "transferred": many and 6 < change.max() < 10,
        }
        return Boxes3D.empty() if attack[self.under] else truth_of(frame)

    def detect_batch(self, batch: Any) -> list[Boxes3D]:
        raise NotImplementedError

    def losses(self, batch: Any, truth: Any, disparity: Any = None) -> Any:
        return {"loss": torch.zeros(())}


class Towards:
    """Stands for an attack by gradients: changes pixels by 4 grey levels, or 8 by another's."""

    name = "towards"
    budget = Budget(8.0)

    def attack(self, frame: SensorFrame, victim: Victim, seed: Seed = 0) -> SensorFrame:
        change = 4.0 if isinstance(victim.detector, Fooled) else 8.0
        for camera in (2, 3):
            image = frame.image(camera).astype(np.float32)
            frame = frame.with_image(camera, np.where(image < 128, image + change, image - change))
        return frame


@pytest.mark.parametrize("under", ["white_box", "transferred", "patch"])
def test_gradients_that_lead_nowhere(
    few: dict[str, FrozenSet], tmp_path: Path, under: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They are masked where another's harm more; a patch is of another budget, and not compared."""
    name = f"fooled_under_{under}"
    if name not in names(Kind.DETECTOR):
        register(Kind.DETECTOR, name, lambda: Fooled(under))
    if "towards" not in names(Kind.ATTACK):
        register(Kind.ATTACK, "towards", Towards)
    for attack in ("PERTURBATION", "STRONGER"):
        monkeypatch.setattr(protocol, attack, {"name": "towards"})
    for module in (query_rows, adaptive_rows):
        monkeypatch.setattr(module, "paired_differences", certain_differences)
    found = made("detector", name, tmp_path)
    assert found.white_box is True
    assert [row.setting for row in found.rows][-2:] == ["white_box", "adaptive"]
    assert found.row("contested", under).rates.safe_driving_rate == 0.0
    assert found.masked is (under == "transferred")
    # The adaptive attack here does as much as the worst of the listed ones of its budget.
    assert found.broken is False
    adaptive = found.row("contested", "adaptive").rates.safe_driving_rate
    assert adaptive == (1.0 if under == "patch" else 0.0)


@pytest.mark.parametrize("limit", [10, 100])
def test_a_detector_that_a_stronger_attack_of_the_budget_breaks(
    few: dict[str, FrozenSet], tmp_path: Path, limit: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It bears noise up to a limit, which the listed attacks do not reach, and the adaptive may."""

    class Bears:
        name = f"bears_{limit}"

        def detect(self, frame: SensorFrame) -> Boxes3D:
            change = change_of(frame)
            few_change = np.median(change) < 1  # A patch, or nothing.
            return truth_of(frame) if few_change or change.max() < limit else Boxes3D.empty()

    if Bears.name not in names(Kind.DETECTOR):
        register(Kind.DETECTOR, Bears.name, Bears)
    monkeypatch.setattr(protocol, "STRONGER", {"name": "random_noise", "strength": 40.0})
    monkeypatch.setattr(adaptive_rows, "paired_differences", certain_differences)
    found = made("detector", Bears.name, tmp_path)
    [row] = found.adaptive
    assert (row.setting, row.measure, row.detected) == ("adaptive", "safe", None)
    assert found.broken is row.breaks is (limit == 10)
    safe = found.row("contested", "adaptive").rates.safe_driving_rate
    assert safe == (0.0 if limit == 10 else 1.0)
    again = read_entry(tmp_path / "entry.json")
    assert again.to_json() == found.to_json()
    assert again.broken is found.broken


class Suspicious:
    """Reports camera 2 in every frame."""

    name = "suspicious"
    system = SensorSystem((LIDAR, 2, 3))

    def validate(self, frame: SensorFrame) -> Validation:
        statuses = {2: SensorStatus.ATTACKED, 3: SensorStatus.SOUND}
        return Validation(True, statuses, None)  # type: ignore[arg-type]


def test_a_validator_that_always_reports_one_camera(
    few: dict[str, FrozenSet], tmp_path: Path
) -> None:
    if "suspicious" not in names(Kind.VALIDATOR):
        register(Kind.VALIDATOR, "suspicious", Suspicious)
    entry = made("validator", "suspicious", tmp_path)
    clean, attacked = (entry.row("all", f"{case} validated") for case in ("unattacked", "facula"))
    assert (clean.alarms.count, clean.alarms.of, clean.named.count) == (2, 2, 0)
    assert (attacked.alarms.count, attacked.named.count) == (2, 2)
    assert entry.row("all", "facula").alarms is None
    assert clean.against == "unattacked"
    assert clean.paired.episodes == 6


class Dazzled:
    """Sees the truth, and nothing once a tenth of the image, or of its middle, is lit."""

    name = "dazzled"

    def detect(self, frame: SensorFrame) -> Boxes3D:
        lit = change_of(frame) > 20
        rows, columns = lit.shape
        middle = lit[rows // 3 : rows, columns // 3 : 2 * columns // 3]
        return Boxes3D.empty() if max(lit.mean(), middle.mean()) > 0.1 else truth_of(frame)


class Watchman:
    """Reports camera 2 where so large a share of its pixels changed."""

    system = SensorSystem((LIDAR, 2, 3))

    def __init__(self, name: str, most: float) -> None:
        self.name, self.most = name, most

    def validate(self, frame: SensorFrame) -> Validation:
        alarm = bool((change_of(frame) > 0).mean() > self.most)
        left = SensorStatus.ATTACKED if alarm else SensorStatus.SOUND
        return Validation(alarm, {2: left, 3: SensorStatus.SOUND}, None)  # type: ignore[arg-type]


@pytest.mark.parametrize(("name", "most", "blind"), [("drowsy", 0.6, True), ("alert", 0.0, False)])
def test_a_validator_that_is_blind_to_a_quiet_attack(
    few: dict[str, FrozenSet],
    tmp_path: Path,
    name: str,
    most: float,
    blind: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The listed light is everywhere and alarms both; of less, one of them knows nothing."""
    if name not in names(Kind.VALIDATOR):
        register(Kind.VALIDATOR, name, lambda: Watchman(name, most))
    if "dazzled" not in names(Kind.DETECTOR):
        register(Kind.DETECTOR, "dazzled", Dazzled)
    wide = {"name": "facula", "camera": 2, "radius": 2000.0, "centre": [160.0, 60.0]}
    harmless = {**wide, "radius": 5.0}
    quiet = {**wide, "radius": 150.0, "centre": [160.0, 90.0]}
    monkeypatch.setattr(protocol, "OPTICAL", {"facula": ("dazzled", wide)})
    monkeypatch.setattr(adaptive_rows, "OPTICAL", {"facula": ("dazzled", wide)})
    monkeypatch.setattr(protocol, "QUIETER", {"facula": [harmless, quiet]})
    monkeypatch.setattr(
        adaptive_rows,
        "mean_over_scenes",
        lambda values, scenes: Mean(float(values.mean()), (float(values.mean()),) * 2),
    )
    entry = made("validator", name, tmp_path / "one")
    listed = entry.row("contested", "facula validated")
    under = entry.row("contested", "facula adaptive validated")
    assert entry.row("all", "facula adaptive validated") is None
    assert listed.alarms.rate == 1.0
    assert listed.collided.count == 0
    [row] = entry.adaptive
    assert (row.setting, row.against) == ("facula adaptive validated", "facula validated")
    assert row.detected == under.alarms
    assert row.detected.rate == (0.0 if blind else 1.0)
    assert under.collided.count == (under.collided.of if blind else 0)
    assert entry.broken is blind
    again = made("validator", name, tmp_path / "two")
    assert again.to_json() == entry.to_json()


def test_what_is_no_entry(tmp_path: Path, few: dict[str, FrozenSet]) -> None:
    path = tmp_path / "entry.json"
    path.write_text("{}")
    with pytest.raises(DataError, match="no entry of the benchmark"):
        read_entry(path)
    entry = made("planner", "astar", tmp_path / "made").to_json()
    for damage in ({"rows": 3}, {"kind": "car"}, {"rows": [{}]}, {"scenes": [1]}):
        path.write_text(json.dumps({**entry, **damage}))
        with pytest.raises(DataError, match="is damaged"):
            read_entry(path)


def test_a_slip_leaves_no_folder(few: dict[str, FrozenSet], tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match="Did you mean"):
        made("planner", "asta", tmp_path / "out")
    assert not (tmp_path / "out").exists()
