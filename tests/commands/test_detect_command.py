"""`avsec detect`: a folder that `avsec ap` scores, in as many sittings as it takes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from avsec_gym import registry
from avsec_gym.boxes import Boxes3D
from avsec_gym.cli import run
from avsec_gym.errors import DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti import read_detections, write_calibration, write_labels
from avsec_gym.perception import result_folder
from avsec_gym.perception.detectors.image_detector import image_boxes
from avsec_gym.perception.result_folder import RecordedDetector
from avsec_gym.registry import Kind
from avsec_gym.rig import kitti_rig

DONE, BAD_DATA, BAD_USAGE, IN_PART = 0, 1, 2, 3
IDS = [f"{number:06d}" for number in range(5)]


def car(x: float, score: float = 1.0) -> Boxes3D:
    return Boxes3D(
        [[x, 1.65, 20]], [[1.5, 1.6, 4]], [0.0], [score], ["Car"], box2d=[[500, 150, 600, 220]],
        truncation=[0], occlusion=[0], alpha=[0],
    )  # fmt: skip


class Sleepy:
    """Sees nothing in frame 1, cannot use frame 3, and counts how often it looked."""

    name = "sleepy"
    looks = 0

    def __init__(self, score: float = 0.5) -> None:
        self._score = score

    def detect(self, frame: SensorFrame) -> Boxes3D:
        Sleepy.looks += 1
        if frame.id == IDS[3]:
            raise DataError("too dark to see.", path=frame.origin)
        if frame.id == IDS[1]:
            return Boxes3D.empty()
        return car(float(int(frame.id)), self._score)


@pytest.fixture(autouse=True)
def _sleepy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(registry._REGISTERED, (Kind.DETECTOR, "sleepy"), Sleepy)
    monkeypatch.setattr(Sleepy, "looks", 0)


@pytest.fixture
def kitti(tmp_path: Path) -> Path:
    root = tmp_path / "kitti"
    for id in IDS:
        write_calibration(root / "training/calib" / f"{id}.txt", kitti_rig().calibration)
        write_labels(root / "training/label_2" / f"{id}.txt", car(float(int(id))))
    (root / "ImageSets").mkdir()
    (root / "ImageSets/val.txt").write_text("\n".join(IDS[:3]))
    return root


def ends(*arguments: Any) -> int:
    try:
        return run(["detect", *map(str, arguments)])
    except SystemExit as end:
        return int(end.code or 0)


def files(folder: Path) -> list[str]:
    return sorted(path.stem for path in folder.glob("*.txt"))


def test_a_result_folder_with_empty_files_and_without_unseen_frames(
    kitti: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "results"
    usual = ("--kitti", kitti, "--detector", "sleepy", "--out", out)
    assert ends(*usual, "--json") == IN_PART
    output = capsys.readouterr()
    assert "too dark to see" in output.err
    summary = json.loads(output.out)
    assert (summary["written"], summary["kept"], list(summary["left_out"])) == (4, 0, [IDS[3]])
    assert files(out) == [IDS[0], IDS[1], IDS[2], IDS[4]]
    assert (out / f"{IDS[1]}.txt").read_text() == ""
    found = read_detections(out / f"{IDS[4]}.txt")
    assert found.location.tolist() == [[4.0, 1.65, 20.0]]
    assert found.score.tolist() == [0.5]


def test_a_stopped_run_goes_on(
    kitti: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "results"
    usual = ("--kitti", kitti, "--detector", "sleepy", "--out", out, "--split", "val")
    assert ends(*usual, "--limit", 2) == DONE
    before = (out / f"{IDS[0]}.txt").stat().st_mtime_ns
    assert ends(*usual) == DONE
    assert Sleepy.looks == 3
    assert (out / f"{IDS[0]}.txt").stat().st_mtime_ns == before
    assert "1 frames written, 2 were there, 0 left out" in capsys.readouterr().err


def test_results_of_two_detectors_do_not_mix(
    kitti: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "results"
    usual = ("--kitti", kitti, "--out", out, "--ids", IDS[0])
    assert ends(*usual, "--detector", '{"name": "sleepy", "score": 0.25}') == DONE
    assert read_detections(out / f"{IDS[0]}.txt").score.tolist() == [0.25]
    assert ends(*usual, "--detector", "sleepy") == BAD_DATA
    assert "another detector" in capsys.readouterr().err
    (out / "detector.json").unlink()
    assert ends(*usual, "--detector", "sleepy") == BAD_DATA


def test_results_of_two_weights_do_not_mix(
    kitti: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The weights of a network change under its name; the record keeps those that were used."""
    out = tmp_path / "results"
    usual = ("--kitti", kitti, "--detector", "sleepy", "--out", out, "--split", "val")
    monkeypatch.setattr(result_folder, "weights_file_hash", lambda detector: "0123")
    assert ends(*usual, "--limit", 1) == DONE
    assert result_folder.recorded_detector(out) == RecordedDetector("sleepy", "", "0123")
    monkeypatch.setattr(result_folder, "weights_file_hash", lambda detector: "4567")
    assert ends(*usual) == BAD_DATA
    assert "other weights" in capsys.readouterr().err


@pytest.mark.slow
def test_several_workers_write_the_same_files(kitti: Path, tmp_path: Path) -> None:
    (kitti / "training/label_2" / f"{IDS[3]}.txt").write_text("Car 0 0\n")
    one, two = tmp_path / "one", tmp_path / "two"
    usual = ("--kitti", kitti, "--detector", "oracle")
    assert ends(*usual, "--out", one) == IN_PART
    assert ends(*usual, "--out", two, "--workers", 2) == IN_PART
    assert files(one) == files(two) == [IDS[0], IDS[1], IDS[2], IDS[4]]
    for id in files(one):
        assert (one / f"{id}.txt").read_bytes() == (two / f"{id}.txt").read_bytes()


def test_what_cannot_work_is_refused(
    kitti: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    usual = ("--kitti", kitti, "--out", tmp_path / "results")
    for workers in (1, 2):
        assert ends(*usual, "--detector", "unheard_of", "--workers", workers) == BAD_USAGE
        assert "no detector named 'unheard_of'" in capsys.readouterr().err
    assert ends(*usual, "--detector", '{"name": ') == BAD_USAGE
    assert ends(*usual, "--detector", "sleepy", "--workers", 0) == BAD_USAGE
    assert ends(*usual, "--detector", "sleepy", "--limit", 0) == BAD_USAGE
    assert ends(*usual, "--detector", "sleepy", "--ids", IDS[0], "--split", "val") == BAD_USAGE
    assert ends(*usual, "--detector", "sleepy", "--split", "test") == BAD_DATA
    assert ends(*usual, "--detector", "sleepy", "--ids", IDS[3]) == BAD_DATA
    assert "too dark" in capsys.readouterr().err
    assert ends(*usual, "--detector", "sleepy", "--ids", "000099") == BAD_DATA
    assert not files(tmp_path / "results")


class Peephole:
    """Sees a car at the left edge of image 2, and at the right edge of others."""

    name = "peephole"

    def detect(self, frame: SensorFrame, camera: int = 2) -> Boxes3D:
        left = 0.0 if camera == 2 else 1000.0
        return image_boxes(np.array([[left, 100, left + 90, 180]]), np.array([0.7]), ["Car"])


@pytest.mark.parametrize(
    ("camera", "left"), [((), 0.0), (("--camera", 2), 0.0), (("--camera", 3), 1000.0)]
)
@pytest.mark.parametrize("asked", ["peephole", '{"name": "peephole"}'])
def test_a_detector_of_single_images_looks_at_one_camera(
    kitti: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    asked: str,
    camera: tuple[Any, ...],
    left: float,
) -> None:
    monkeypatch.setitem(registry._REGISTERED, (Kind.IMAGE_DETECTOR, "peephole"), Peephole)
    out = tmp_path / "results"
    assert ends("--kitti", kitti, "--detector", asked, "--out", out, *camera) == DONE
    for id in IDS:
        found = read_detections(out / f"{id}.txt")
        assert found.box2d is not None
        assert found.box2d[0, 0] == left


def test_a_camera_is_for_detectors_of_single_images(
    kitti: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for asked in ("sleepy", '{"name": "sleepy"}'):
        arguments = ("--kitti", kitti, "--detector", asked, "--out", tmp_path, "--camera", 3)
        assert ends(*arguments) == BAD_USAGE
        assert "--camera is for faster_rcnn, yolo" in capsys.readouterr().err
