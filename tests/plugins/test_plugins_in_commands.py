"""A package of somebody else's brings parts of its own: every command takes them by their names.

It is installed as pip would, in a folder that Python looks into; some commands have workers, which
have to find it by themselves.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from avsec_gym import registry
from avsec_gym.boxes import Boxes3D
from avsec_gym.cli import run
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.writing import write_object_frame
from avsec_gym.rig import camera_rig
from avsec_gym.road_type import RoadType
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.scenario.builder import build_planning_scenario
from avsec_gym.scenario.commonroad import write_commonroad

HERE = Path(__file__).parent
RIG = camera_rig([0.0, 0.0, 0.0, 0.5], focal_length=200.0, centre=(120.0, 60.0), size=(240, 120))
IDS = ("000001", "000002", "000003")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What pip would write."""
    site = tmp_path_factory.mktemp("site")
    shutil.copy(HERE / "mine.py", site / "mine.py")
    about = site / "mine-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: mine\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text("[avsec_gym.plugins]\nmine = mine:load\n")
    return site


@pytest.fixture
def installed(site: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As if this process, and those that it starts, had begun with the package there."""
    paths = [str(site), str(HERE.parents[1]), *filter(None, [os.environ.get("PYTHONPATH")])]
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(paths))
    monkeypatch.syspath_prepend(site)
    monkeypatch.setattr(registry, "_REGISTERED", {})
    monkeypatch.setattr(registry, "_PLUGINS_LOADED", False)


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Dark frames with an empty road ahead, each with a label far away; a planning problem."""
    root = tmp_path_factory.mktemp("data")
    far = Boxes3D(
        [[6.0, 1.65, 45.0]], [[1.5, 1.6, 4.0]], [-np.pi / 2], [1.0], ["Car"],
        box2d=[[140.0, 60.0, 160.0, 70.0]], truncation=[0.0], occlusion=[0], alpha=[0.0],
    )  # fmt: skip
    x, y = np.meshgrid(np.linspace(-5, 5, 60), np.linspace(-2, 2, 20))
    places = np.stack([x.ravel(), y.ravel(), np.full(x.size, 8.0), np.ones(x.size)], axis=1)
    points = (places @ RIG.calibration.camera_to_velodyne.T).astype(np.float32)
    for number, id in enumerate(IDS):
        dots = np.random.default_rng(number).integers(0, 120, (120, 260, 1), np.uint8)
        dots = dots.repeat(3, axis=2)
        images = {2: dots[:, :240], 3: dots[:, 12:252]}
        write_object_frame(root / "training", SensorFrame(id, RIG.calibration, images, points), far)
    problem = build_planning_scenario(Boxes3D.empty(), road_type=RoadType.STREET, id="free")
    write_commonroad(problem, root / "free.xml")
    return root


class Ended(NamedTuple):
    stdout: str
    stderr: str


@pytest.fixture
def avsec(
    installed: None,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> Any:
    monkeypatch.chdir(tmp_path)

    def command(*words: Any, code: int = 0) -> Ended:
        assert run([str(word) for word in words]) == code
        return Ended(*capsys.readouterr())

    return command


IMPATIENT = json.dumps({"name": "mine", "patience": 0})


def test_a_planner_in_evaluate(avsec: Any, data: Path, tmp_path: Path) -> None:
    common = ["evaluate", "--scenarios", data / "training/label_2", "--intention", "straight"]
    done = avsec(*common, "--planner", "mine", "--json")
    (row,) = json.loads(done.stdout)["rates"]
    assert (row["planner"], row["planned"], row["scenarios"]) == ("mine", 3, 3)
    # With arguments; with what it did not plan in pictures; and at several thresholds.
    avsec("detect", "--kitti", data, "--detector", "mine", "--out", tmp_path / "seen")
    more = ["--detections", tmp_path / "seen", "--out", tmp_path / "out", "--sweep", "2"]
    report = json.loads(avsec(*common, *more, "--planner", IMPATIENT, "--json").stdout)
    assert {(row["planner"], row["planned"]) for row in report["rates"]} == {("mine", 0)}
    assert {(row["planner"], row["planned"]) for row in report["sweep"]} == {("mine", 0)}
    assert [row["failures"] for row in report["rates"]] == [{"unknown": 3}] * 2
    assert (tmp_path / "out" / "evaluation.json").is_file()


def test_a_shell_finds_them_too(installed: None, data: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "avsec_gym", "plan", data / "free.xml", "--planner", "mine"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert "4242" in done.stdout


def test_a_planner_in_plan_and_draw(avsec: Any, data: Path, tmp_path: Path) -> None:
    row = json.loads(avsec("plan", data / "free.xml", "--planner", "mine", "--json").stdout)
    assert (row["status"], row["expanded"]) == ("found", 4242)
    words = ["plan", data / "free.xml", "--planner", IMPATIENT, "--pictures", tmp_path / "p"]
    assert json.loads(avsec(*words, "--json").stdout)["status"] == "limit"
    assert (tmp_path / "p" / "free.png").is_file()
    refused = avsec(*words[:4], "--mode", "reference", code=2)
    assert "--mode belongs to --planner astar and gbfs; mine takes" in refused.stderr
    drawn = avsec("draw", "000002", "--scenarios", data / "training/label_2", "--planner", "mine")
    assert "4242 nodes" in drawn.stderr
    assert (tmp_path / "000002_straight.png").is_file()


def test_a_name_that_nothing_has_is_asked_about(avsec: Any, data: Path) -> None:
    for words in (
        ["evaluate", "--planner", "mien"],
        ["plan", data / "free.xml", "--planner", "mien"],
        ["draw", "street-000003", "--planner", "mien"],
        ["validate", "--kitti", data, "--validator", "mien"],
        ["detect", "--kitti", data, "--detector", "mien", "--out", "o"],
        ["run", "pipeline", "--scenarios", data, "--planner", "mien", "--workers", "0"],
    ):
        assert 'Did you mean "mine"?' in avsec(*words, code=2).stderr
    for words in (
        ["validate", "--kitti", data, "--validator", "mine", "--attack", "glaer"],
        ["detect", "--kitti", data, "--detector", "mine", "--attack", "glaer", "--out", "o"],
    ):
        assert "glaer" in avsec(*words, code=2).stderr


@pytest.mark.parametrize("workers", [1, 2])
def test_a_detector_under_an_attack_in_detect(
    avsec: Any, data: Path, tmp_path: Path, workers: int
) -> None:
    asked = json.dumps({"name": "mine", "distance": 20.0})
    common = ["detect", "--kitti", data, "--detector", asked, "--workers", workers, "--json"]
    assert json.loads(avsec(*common, "--out", tmp_path / "clean").stdout)["written"] == 3
    for id in IDS:
        assert float((tmp_path / "clean" / f"{id}.txt").read_text().split()[13]) == 20.0
    for name, attack in (
        ("glare", json.dumps({"name": "glare", "camera": 2})),
        ("blinding", "blinding"),
    ):
        avsec(*common, "--attack", attack, "--out", tmp_path / name)
        assert [(tmp_path / name / f"{id}.txt").read_text() for id in IDS] == [""] * 3
    # The other camera is none that this detector looks at.
    attack = json.dumps({"name": "glare", "camera": 3})
    avsec(*common, "--attack", attack, "--out", tmp_path / "other")
    assert (tmp_path / "other" / "000001.txt").read_text()


def test_a_validator_and_an_attack_in_validate(avsec: Any, data: Path, tmp_path: Path) -> None:
    common = ["validate", "--kitti", data, "--validator", "mine", "--json"]
    *rows, last = map(json.loads, avsec(*common, "--out", tmp_path / "clean").stdout.splitlines())
    assert [row["alarm"] for row in rows] == [False] * 3
    attack = json.dumps({"name": "glare", "camera": 3})
    done = avsec(*common, "--attack", attack, "--out", tmp_path / "attacked")
    *rows, last = map(json.loads, done.stdout.splitlines())
    assert [(row["attacked"], row["truly_attacked"]) for row in rows] == [([3], [3])] * 3
    assert last["summary"]["attacks_named"]["rate"] is None
    assert last["summary"]["attacks_detected"]["count"] == 3
    assert len(list((tmp_path / "attacked" / "alarms").iterdir())) == 3
    # It has no sensitivity of this command's, and judges the sensors that it judges.
    assert "--rate" in avsec(*common, "--rate", "0.1", code=2).stderr
    assert "lidar 3 2" in avsec(*common, "--sensors", "3", "2", code=2).stderr


@pytest.mark.parametrize("workers", [0, 2])
def test_all_of_them_in_run(avsec: Any, data: Path, tmp_path: Path, workers: int) -> None:
    out = tmp_path / "run"
    words = ["run", "pipeline", "--scenarios", data, "--workers", workers, "--out", out, "--json"]
    done = avsec(
        *words, "--detector", "mine", "--planner", "mine", "--validator", "mine",
        "--attack", json.dumps({"name": "glare", "camera": 2}),
        "--options", "response=stop",
    )  # fmt: skip
    assert json.loads(done.stdout)["failed"] == 0
    there = RunFolder.open(out)
    assert [name for name, _ in there.settings()] == [
        "pipeline attacked", "pipeline truth", "pipeline unattacked",
    ]  # fmt: skip
    assert {row["planner"] for row in there.drives()} == {"mine"}
    # A ghost in the way of the unattacked car; under attack the validator stops it.
    assert all(record.planned for record in there.records(setting="pipeline truth"))
    assert all(len(boxes) == 1 for boxes in there.detections("pipeline unattacked").values())
    assert all(len(boxes) == 0 for boxes in there.detections("pipeline attacked").values())
    expanded = {row["expanded"] for row in there.drives(setting="pipeline truth")}
    assert expanded == {4242}


def test_an_experiment_that_takes_no_such_part_says_so(avsec: Any, data: Path) -> None:
    done = avsec("run", "unattacked", "--scenarios", data, "--planner", "mine", code=2)
    assert "there is no option 'planner'" in done.stderr
    done = avsec("run", "pipeline", "--scenarios", data, "--options", "planer=mine", code=2)
    assert 'Did you mean "planner"?' in done.stderr
