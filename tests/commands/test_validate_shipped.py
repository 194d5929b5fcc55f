"""`avsec validate` on one frame: by what the package ships, if that is of such a rig."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from avsec_gym.cli import run
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.raw_calibration import write_raw_calibration
from avsec_gym.kitti.writing import write_object_frame, write_raw_frame
from avsec_gym.rig import SensorRig, camera_rig, kitti_rig
from avsec_gym.sensor_system import SensorSystem
from avsec_gym.validation.shipped import shipped_file

NOT_HERE = "not on this vehicle"
FACULA = '{"name": "facula", "camera": 3, "radius": 250, "strength": 600}'
SMALL = camera_rig([0.0, 0.6, -0.1, 0.4], focal_length=200.0, centre=(120.0, 60.0), size=(240, 120))


def wall(number: int, rig: SensorRig, cameras: tuple[int, ...]) -> SensorFrame:
    """Grey dots of some size on a wall 12 m ahead."""
    width, height = rig.size
    depth, focal = 12.0, float(rig.calibration.focal_length(2))
    right = {camera: float(rig.calibration.camera_centre(camera)[0]) for camera in cameras}
    shift = {
        camera: round(focal * (x - min(right.values())) / depth) for camera, x in right.items()
    }
    rng = np.random.default_rng(number)
    dots = rng.integers(40, 140, (height // 4 + 1, (width + 200) // 4, 1), np.uint8)
    dots = dots.repeat(4, axis=0).repeat(4, axis=1).repeat(3, axis=2)[:height]
    images = {camera: dots[:, shift[camera] :][:, :width] for camera in cameras}
    x, y = np.meshgrid(np.linspace(-9, 9, 400), np.linspace(-2, 2, 60))
    places = np.stack([x.ravel(), y.ravel(), np.full(x.size, depth), np.ones(x.size)], axis=1)
    points = (places @ rig.calibration.camera_to_velodyne.T).astype(np.float32)
    return SensorFrame(f"{number:06d}", rig.calibration, images, points)


@pytest.fixture(scope="module")
def kitti(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two frames of the object layout, of KITTI's rig; a third one lacks its scan."""
    root = tmp_path_factory.mktemp("object")
    for number in range(3):
        frame = wall(number, kitti_rig(), (2, 3))
        write_object_frame(root / "training", frame)
    (root / "training" / "velodyne" / "000002.bin").unlink()
    return root


def drive_of(root: Path, rig: SensorRig, count: int) -> Path:
    drive = root / "2026_01_01" / "2026_01_01_drive_0001_sync"
    write_raw_calibration(drive.parent, rig.calibration, image_size=rig.size)
    for number in range(count):
        write_raw_frame(drive, number, wall(number, rig, (1, 2, 3)))
    return drive


Told = Callable[..., tuple[list[dict[str, Any]], str]]


@pytest.fixture
def validated(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> Told:
    def command(*arguments: object, code: int = 0) -> tuple[list[dict[str, Any]], str]:
        out = ["--out", str(tmp_path / "out")]
        assert run(["validate", *map(str, arguments), *out, "--json"]) == code
        told = capsys.readouterr()
        return [json.loads(line) for line in told.out.splitlines()], told.err

    return command


def test_one_frame_is_judged_by_one_command(kitti: Path, validated: Told, tmp_path: Path) -> None:
    (row, last), told = validated("--kitti", kitti, "--ids", "000001")
    assert row["id"] == "000001"
    assert not row["alarm"]
    # Where it comes from stands in every output.
    out = tmp_path / "out"
    written = json.loads((out / "summary.json").read_text())
    for said in (row["fitted_on"], last["summary"]["fitted_on"], written["fitted_on"], told):
        assert NOT_HERE in said
        assert "procedural drives of KITTI's rig, seed" in said
    assert [path.name for path in (out / "no_alarms").iterdir()] == ["000001.png"]
    assert not (out / "thresholds.json").exists()


@pytest.mark.parametrize("by", ["thresholds", "likelihood"])
def test_an_attack_on_one_frame_raises_an_alarm(
    kitti: Path, validated: Told, tmp_path: Path, by: str
) -> None:
    asked = ["--ids", "000000", f"--{by}", "shipped", "--attack", FACULA]
    (row, last), _ = validated("--kitti", kitti, *asked)
    assert row["alarm"]
    assert last["summary"]["attacks_detected"]["count"] == 1
    assert (row["probabilities"] is None) == (by == "thresholds")
    assert [path.name for path in (tmp_path / "out" / "alarms").iterdir()] == ["000000.png"]


def test_a_drive_of_one_frame_is_judged(validated: Told, tmp_path: Path) -> None:
    drive = drive_of(tmp_path, kitti_rig(), 1)
    (row, _), told = validated("--kitti-raw", drive)
    assert list(row["statuses"]) == ["lidar", "1", "3", "2"]
    assert NOT_HERE in told


def test_a_frame_that_is_not_there_is_said(kitti: Path, validated: Told) -> None:
    _, told = validated("--kitti", kitti, "--ids", "000007", code=1)
    assert "no frame 000007" in told
    assert "that can be judged are 000000, 000001" in told
    _, told = validated("--kitti", kitti, "--ids", "000002", code=1)
    assert "000002 lacks velodyne" in told


def test_one_frame_of_another_rig_is_refused(validated: Told, tmp_path: Path) -> None:
    drive = drive_of(tmp_path, SMALL, 1)
    _, told = validated("--kitti-raw", drive, code=2)
    assert "of 1 frames none is left to be judged" in told
    assert "the package's thresholds do not hold here" in told
    assert "cameras that stand otherwise" in told
    _, told = validated("--kitti-raw", drive, "--likelihood", "shipped", code=2)
    assert "the package's likelihoods do not hold here" in told


def test_who_has_enough_clean_frames_is_judged_by_these(validated: Told, tmp_path: Path) -> None:
    drive = drive_of(tmp_path, kitti_rig(), 8)
    *rows, _ = validated("--kitti-raw", drive, "--rate", "0.5", "--sensors", "lidar", "3", "2")[0]
    assert len(rows) == 6
    assert rows[0]["fitted_on"] == f"fitted on 2 clean frames of {drive.name}"
    assert (tmp_path / "out" / "thresholds.json").exists()


def test_too_few_clean_frames_of_another_rig_have_to_do(validated: Told, tmp_path: Path) -> None:
    drive = drive_of(tmp_path, SMALL, 4)
    (*rows, _), told = validated("--kitti-raw", drive)
    assert len(rows) == 3
    assert "the package's thresholds do not hold here" in told
    assert "fitted on 1 clean frames" in told


def test_named_frames_are_judged_by_the_others(validated: Told, tmp_path: Path) -> None:
    drive = drive_of(tmp_path, kitti_rig(), 4)
    asked = ["--ids", "0000000000", "--clean", "0.5", "--sensors", "lidar", "3", "2"]
    (row, _), _ = validated("--kitti-raw", drive, *asked)
    assert row["id"] == "0000000000"
    samples = (tmp_path / "out" / "samples.jsonl").read_text().splitlines()
    assert [json.loads(line)["id"] for line in samples] == ["0000000001", "0000000002"]
    _, told = validated("--kitti-raw", drive, "--clean", "0.5", "--thresholds", "shipped", code=2)
    assert "--clean states what is fitted on" in told


def test_a_shipped_file_of_an_older_format_is_refused(
    kitti: Path, validated: Told, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    system = SensorSystem(("lidar", 3, 2))
    content = json.loads(shipped_file("thresholds", system).read_text())
    content["format"] -= 1
    other = tmp_path / "fits" / shipped_file("thresholds", system).name
    other.parent.mkdir()
    other.write_text(json.dumps(content))
    monkeypatch.setattr(
        "avsec_gym.validation.shipped.shipped_file", lambda kind, system, folder=None: other
    )
    _, told = validated("--kitti", kitti, "--ids", "000001", code=1)
    assert f"in format {content['format']}" in told


def test_a_real_frame_is_judged_by_one_command(shared: Path, validated: Told) -> None:
    (row, _), told = validated("--kitti", shared / "kitti" / "object", "--ids", "000107")
    assert list(row["statuses"]) == ["lidar", "3", "2"]
    assert NOT_HERE in told
    assert not row["alarm"]
