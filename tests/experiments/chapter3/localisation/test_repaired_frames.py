"""How located and repaired damage is judged, from a wall of dots to the page."""

from __future__ import annotations

import json
import math
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from avsec_gym import registry
from avsec_gym.attacks.facula import Facula
from avsec_gym.attacks.lidar_spoofing import LidarSpoofing
from avsec_gym.boxes import Boxes3D
from avsec_gym.commands.report import Report
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.experiments.chapter3.experiments import LOCALISATION
from avsec_gym.experiments.chapter3.localisation import repaired_frames
from avsec_gym.experiments.chapter3.localisation.measures import (
    CAR,
    Overlap,
    attacks_of,
    found_again,
    overlap,
)
from avsec_gym.experiments.chapter3.localisation.rates import (
    LocatedAttack,
    LocatedFrame,
    localisation_summary,
)
from avsec_gym.experiments.chapter3.localisation.repair_pictures import SHOWN
from avsec_gym.experiments.chapter3.localisation.repaired_frames import RepairedFrames
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import transform_points
from avsec_gym.kitti.raw_calibration import write_raw_calibration
from avsec_gym.kitti.writing import write_raw_frame
from avsec_gym.report.run_markdown import markdown_page
from avsec_gym.report.run_report import run_report
from avsec_gym.rig import camera_rig
from avsec_gym.runs.experiment import CellResult, Configuration, Measurement
from avsec_gym.runs.run import run_experiments
from avsec_gym.runs.run_folder import RunFolder

FACULA, BOGUS = SHOWN.values()
PLACES = (0.0, 0.54, -0.27, 0.27)
RIG = camera_rig(PLACES, focal_length=200.0, centre=(120.0, 60.0), size=(240, 120))
LABEL = "Car 0.00 0 -1.57 100.00 50.00 140.00 90.00 1.50 1.60 4.00 0.00 1.65 10.80 -1.57\n"
SIGN = (110.0, 50.0, 150.0, 80.0)
"""A 2D box in the middle of camera 2's image."""


def wall(number: int) -> SensorFrame:
    """A wall of dark random dots 10.8 m ahead."""
    random = np.random.default_rng(number)
    dots = random.integers(0, 100, (120, 300, 1), np.uint8).repeat(3, axis=2)
    starts = [20 + round(200 * place / 10.8) for place in PLACES]
    images = {camera: dots[:, start : start + 240] for camera, start in enumerate(starts)}
    x, y = np.meshgrid(np.linspace(-6, 6, 200), np.linspace(-3, 3, 60))
    spots = np.stack([x.ravel(), y.ravel(), np.full(x.size, 10.8), np.ones(x.size)], axis=1)
    points = (spots @ RIG.calibration.camera_to_velodyne.T).astype(np.float32)
    return SensorFrame(f"{number:010d}", RIG.calibration, images, points)


class Reader:
    """Sees a sign wherever light has not made its place bright."""

    name = "reader"

    def detect(self, frame: SensorFrame) -> Boxes3D:
        left, top, right, bottom = map(int, SIGN)
        dark = frame.image(2)[top:bottom, left:right].mean() < 90
        return signs(1)[: int(dark)]


def signs(count: int) -> Boxes3D:
    return Boxes3D(
        np.zeros((count, 3)),
        np.ones((count, 3)),
        np.zeros(count),
        np.ones(count),
        np.full(count, "Car"),
        box2d=np.tile(SIGN, (count, 1)),
    )


@pytest.fixture(scope="module")
def drives(tmp_path_factory: pytest.TempPathFactory) -> Path:
    day = tmp_path_factory.mktemp("drives") / "2026_01_01"
    for number in (1, 2, 3):
        write_raw_frame(day / f"2026_01_01_drive_{number:04d}_sync", 0, wall(number))
    write_raw_calibration(day, RIG.calibration, image_size=RIG.size)
    return day


@pytest.fixture
def two_attacks(monkeypatch: pytest.MonkeyPatch) -> None:
    """One of each kind, light on the sign."""
    two = {FACULA: Facula(2, 225.0, centre=(130.0, 65.0)), BOGUS: attacks_of()[BOGUS]}
    monkeypatch.setattr(repaired_frames, "attacks_of", lambda camera: two)


def test_overlap_of_two_areas() -> None:
    found, true = np.zeros((2, 10, 10), bool)
    found[:, :6] = True
    true[:, 4:] = True
    assert overlap(found, true) == Overlap(20 / 100, 20 / 60, 20 / 60)
    assert overlap(found, ~true | true) == Overlap(0.6, 1.0, 0.6)
    assert overlap(true & ~true, true & ~true) == Overlap(None, None, None)


def test_objects_are_found_again_by_place_and_category() -> None:
    count = 3
    objects = replace(
        signs(count),
        category=np.array(["Car", "Car", "Cyclist"]),
        box2d=np.array([[0, 0, 100, 100], [200, 0, 300, 100], [400, 0, 500, 100.0]]),
    )
    assert found_again(objects, objects) == count
    right = np.array([1.0, 0.0, 1.0, 0.0])
    assert objects.box2d is not None
    moved = replace(objects, box2d=objects.box2d + 40 * right)
    assert found_again(objects, moved) == 0
    moved = replace(objects, box2d=objects.box2d + 30 * right)
    assert found_again(objects, moved) == count
    others = replace(objects, category=np.array(["Car", "Pedestrian", "Car"]))
    assert found_again(objects, others) == 1
    # One box finds one object, though it would do for either.
    twins = replace(
        objects, category=np.full(count, "Car"), box2d=np.tile(objects.box2d[:1], (3, 1))
    )
    assert found_again(twins, twins[:1]) == 1
    assert found_again(objects, Boxes3D.empty()) == 0
    with pytest.raises(ConfigurationError, match="2D boxes"):
        found_again(objects, replace(objects, box2d=None))


def test_every_attack_has_a_name_of_its_own_sensor() -> None:
    assert {next(iter(attack.sensors)) for attack in attacks_of(3).values()} == {3, "lidar"}
    assert set(SHOWN.values()) <= set(attacks_of())


def values_of(result: CellResult, attack: str) -> dict[str, float]:
    return {row.name: row.value for row in result.measurements if row.setting == attack}


@pytest.mark.usefixtures("two_attacks")
def test_a_cell_attacks_repairs_and_counts(drives: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(registry._REGISTERED, (registry.Kind.DETECTOR, "reader"), Reader)
    configuration = Configuration(str(drives), options={"detector": "reader"})
    cells, frames = LOCALISATION.cells(configuration), RepairedFrames(configuration)
    result = frames(**cells[0].arguments)
    facula, bogus = values_of(result, FACULA), values_of(result, BOGUS)
    assert facula["iou"] > 0.5
    assert facula["error_before"] > 50
    assert facula["error_after"] < facula["error_before"] / 3
    assert [facula[name] for name in ("objects", "found_before", "found_after")] == [1, 0, 1]
    assert bogus["iou"] > 0.5
    assert {*bogus} == {"iou", "precision", "recall", "iou_of_lost"}
    assert {row.scenario for row in result.measurements} == {
        "2026_01_01_drive_0001_sync/0000000000"
    }
    repeated = RepairedFrames(configuration)(**cells[0].arguments)
    assert list(repeated.measurements) == list(result.measurements)
    with pytest.raises(DataError, match="no longer there"):
        frames.again("gone", FACULA)


class Whole:
    """Sees a car unless the wall's middle has a hole."""

    name = "whole"

    def detect(self, frame: SensorFrame) -> Boxes3D:
        places = transform_points(frame.calibration.velodyne_to_camera, frame.points[:, :3])
        wall = places[places[:, 2] > 10.2, :2]
        counts, *_ = np.histogram2d(*wall.T, bins=(5, 4), range=((-1.0, 1.0), (0.6, 2.2)))
        seen = [[0.0, 1.65, 12.0]] if (counts > 0).all() else []
        count = len(seen)
        return Boxes3D(
            np.reshape(seen, (-1, 3)), np.tile([1.5, 4.0, 4.0], (count, 1)), np.zeros(count),
            np.full(count, 0.9), ["Car"] * count,
        )  # fmt: skip


@pytest.mark.usefixtures("two_attacks")
def test_what_a_refilled_scan_shows_is_told_apart_from_a_cleaned_one(
    drives: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(registry._REGISTERED, (registry.Kind.DETECTOR, "whole"), Whole)
    monkeypatch.setattr(LidarSpoofing, "_place", lambda *_: (7.0, 0.0))
    for error, after in ((1.0, 1), (0.1, 0)):
        options = {"scan_detector": "whole", "refill_error": error}
        configuration = Configuration(str(drives), options=options)
        cells = LOCALISATION.cells(configuration)
        bogus = values_of(RepairedFrames(configuration)(**cells[0].arguments), BOGUS)
        found = [bogus[f"found_{state}"] for state in ("before", "cleaned", "after")]
        assert [bogus["objects"], *found] == [1, 0, 0, after]


class Near:
    """Sees a car at points that are nearer than the wall, and one in the wall's middle."""

    name = "near"

    def detect(self, frame: SensorFrame) -> Boxes3D:
        assert not frame.images, "a scan is looked at alone"
        places = transform_points(frame.calibration.velodyne_to_camera, frame.points[:, :3])
        near = places[places[:, 2] < 10.2]
        seen = [[0.0, 1.65, 12.0]]
        if len(near) > 150:
            seen.append([near[:, 0].mean(), 1.65, near[:, 2].mean()])
        count = len(seen)
        return Boxes3D(
            seen, np.tile([1.5, 4.0, 4.0], (count, 1)), np.zeros(count), np.full(count, 0.9),
            ["Car"] * count,
        )  # fmt: skip


@pytest.mark.usefixtures("two_attacks")
def test_a_pasted_car_is_gone_after_the_repair(
    drives: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(registry._REGISTERED, (registry.Kind.DETECTOR, "near"), Near)
    # Well before the wall, where disparities tell.
    monkeypatch.setattr(LidarSpoofing, "_place", lambda *_: (7.0, 0.1))
    day = tmp_path / drives.name
    shutil.copytree(drives, day)
    for drive in day.glob("*_sync"):
        (drive / "label_02" / "data").mkdir(parents=True)
        (drive / "label_02" / "data" / "0000000000.txt").write_text(LABEL)
    asked = Configuration(str(day), options={"scan_detector": "near"})
    root = tmp_path / "run"
    assert run_experiments([LOCALISATION], asked, root, workers=0, threads=1).done == 3
    report = run_report(RunFolder.open(root))
    rows = {row["attack"]: row for row in report.data["localisation"]["attacks"]}
    assert list(rows) == [FACULA, BOGUS, CAR]
    for attack in (BOGUS, CAR):
        row = rows[attack]
        assert row["iou"] > 0.5
        assert (row["bogus_clean"], row["bogus_before"]) == (0, 1)
        assert row["bogus_after"] == 0
        assert [row[column] for column in ("objects", "found_before", "found_after")] == [3, 3, 3]
    assert rows[FACULA]["bogus_before"] is None
    [said] = [sentence for sentence in report.sentences if "is pasted" in sentence]
    assert "in 100.0 % of the frames, after the repair in 0.0 %" in said
    assert "bogus obstacle clean" in markdown_page(report)
    frames = RepairedFrames(asked)
    id = f"{next(iter(sorted(day.glob('*_sync')))).name}/0000000000"
    again = frames.again(id, CAR)
    assert len(again.bogus) == 1


@pytest.mark.usefixtures("two_attacks")
def test_from_drives_to_the_page(drives: Path, tmp_path: Path) -> None:
    root = tmp_path / "run"
    asked = Configuration(str(drives), limit=2)
    assert run_experiments([LOCALISATION], asked, root, workers=0, threads=1).done == 2
    assert run_experiments([LOCALISATION], asked, root, workers=0, threads=1).kept == 2
    tables = tmp_path / "tables.md"
    assert Report(root, markdown=tables).run() == 0
    page = (root / "report.html").read_text()
    assert page.count("data:image/webp;base64,") == 4
    assert 'id="localisation"' in page
    assert "otherwise than in the run" not in page
    assert len(list((root / "figures").glob("repair_*.png"))) == 4
    assert f"| {FACULA} | 2 |" in tables.read_text()
    assert Report(root, pictures=0).run() == 0
    assert "data:image/webp" not in (root / "report.html").read_text()
    report = run_report(RunFolder.open(root))
    json.dumps(report.data, allow_nan=False)
    assert [row["attack"] for row in report.data["localisation"]["attacks"]] == [FACULA, BOGUS]


class Rows:
    """Results of one attack, by frame."""

    def __init__(self, values: dict[str, dict[str, float]]) -> None:
        self._values = values

    def measurements(self, setting: str) -> list[Measurement]:
        return [
            Measurement(setting, id, name, value)
            for name, found in self._values.items()
            for id, value in found.items()
            if setting == FACULA
        ]


def summed_up(**values: dict[str, float]) -> LocatedAttack:
    told = localisation_summary(Rows(values), Configuration())  # type: ignore[arg-type]
    assert told is not None
    (row,) = told.attacks
    return row


def test_attacks_are_summed_up() -> None:
    iou = {"a/0": 0.5, "a/1": 0.9, "b/0": 0.1, "b/1": math.nan}
    row = summed_up(
        iou=iou,
        recall=dict.fromkeys(iou, math.nan),
        objects={"a/0": 3.0, "a/1": 2.0},
        found_after={"a/0": 2.0, "a/1": 2.0},
    )
    assert row.frames == 4
    assert row.iou == pytest.approx(0.5)
    assert row.lowest == LocatedFrame("b/0", 0.1)
    assert row.median == LocatedFrame("a/0", 0.5)
    # Of two drives either may be drawn twice.
    assert row.interval == pytest.approx([0.1, 0.7])
    assert row.recall is None
    assert (row.objects, row.found_before, row.found_after) == (5, None, 4)
    assert localisation_summary(Rows({}), Configuration()) is None  # type: ignore[arg-type]


def test_frames_of_one_drive_say_nothing_of_others() -> None:
    assert summed_up(iou={"a/0": 0.5, "a/1": 0.9}).interval is None
    nothing = summed_up(iou={"a/0": math.nan})
    assert (nothing.iou, nothing.interval, nothing.median) == (None, None, None)
