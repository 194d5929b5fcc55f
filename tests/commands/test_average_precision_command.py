"""`avsec ap`: what it prints, how it ends, and what it refuses."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.cli import run
from avsec_gym.kitti import write_detections, write_labels
from avsec_gym.metrics.average_precision import average_precision

DONE, BAD_DATA, BAD_USAGE, IN_PART = 0, 1, 2, 3
ONE_OF_ELEVEN = round(100 / 11, 4)
METRICS = ("2d", "bev", "3d", "aos")


def cars(*places: float, score: float = 0.9) -> Boxes3D:
    count = len(places)
    x = np.array(places, float)
    left = 300 + 100 * x
    return Boxes3D(
        location=np.stack([5 * x, np.full(count, 1.6), np.full(count, 20.0)], axis=1),
        dimensions=np.tile([1.5, 1.6, 4.0], (count, 1)),
        rotation_y=np.zeros(count),
        score=np.full(count, score),
        category=np.full(count, "Car"),
        box2d=np.stack([left, np.full(count, 100.0), left + 90, np.full(count, 180.0)], axis=1),
        truncation=np.zeros(count),
        occlusion=np.zeros(count),
        alpha=np.zeros(count),
    )


@pytest.fixture
def kitti(tmp_path: Path) -> Path:
    """Four frames with a car each; the split `val` leaves the last one out."""
    root = tmp_path / "kitti"
    for number in range(4):
        write_labels(root / "training" / "label_2" / f"{number:06d}.txt", cars(0))
    (root / "ImageSets").mkdir()
    (root / "ImageSets" / "val.txt").write_text("000000\n000001\n000002")
    return root


@pytest.fixture
def detections(tmp_path: Path) -> Path:
    """Each car found, and in the last frame a surer false alarm."""
    root = tmp_path / "detections"
    for number in range(4):
        write_detections(root / f"{number:06d}.txt", cars(0))
    write_detections(root / "000003.txt", cars(1, score=0.99), overwrite=True)
    return root


def refuse_constant(word: str) -> Any:
    raise AssertionError(f"{word} is not JSON")


def scored(capsys: pytest.CaptureFixture[str], *arguments: Any, code: int = DONE) -> Any:
    assert ends("ap", *arguments, "--json") == code
    return json.loads(capsys.readouterr().out, parse_constant=refuse_constant)


def ends(*arguments: Any) -> int:
    try:
        return run([str(argument) for argument in arguments])
    except SystemExit as end:
        return int(end.code or 0)


def test_the_json_has_the_promised_shape(
    kitti: Path, detections: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    report = scored(
        capsys, "--kitti", kitti, "--split", "val", "--detections", detections
    )  # fmt: skip
    assert report.pop("schema") == "avsec.ap/1"
    assert list(report) == ["Car", "Pedestrian", "Cyclist"]
    for category in report.values():
        assert tuple(category) == (*METRICS, "labels", "ceiling")
        assert len(category.pop("labels")) == 3
        for values in category.values():
            assert list(values) == ["ap11", "ap40"]
            assert all(len(levels) == 3 for levels in values.values())
            assert all(math.isfinite(value) for levels in values.values() for value in levels)
    # Three hits at one score make three cuts: recall slots 0, 1 and 2 of 40.  All of three labels.
    assert report["Car"]["ceiling"] == report["Car"]["3d"]
    for metric in METRICS:
        assert report["Car"][metric] == {"ap11": [ONE_OF_ELEVEN] * 3, "ap40": [5.0] * 3}


def test_all_labelled_frames_without_a_split_a_list_or_a_limit(
    kitti: Path, detections: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    usual = ("--kitti", kitti, "--detections", detections)
    # The false alarm is surer than the three hits: three right of four.
    assert scored(capsys, *usual)["Car"]["3d"]["ap11"] == [round(75 / 11, 4)] * 3
    chosen = tmp_path / "chosen.txt"
    chosen.write_text("000003\n000001\n")
    assert scored(capsys, *usual, "--split", chosen)["Car"]["3d"]["ap11"] == [round(50 / 11, 4)] * 3
    assert scored(capsys, *usual, "--limit", 2)["Car"]["3d"]["ap40"] == [2.5] * 3


def test_frames_without_a_file_count_and_are_told(
    kitti: Path, detections: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (detections / "000001.txt").unlink()
    out = tmp_path / "report.json"
    usual = ("--kitti", kitti, "--split", "val", "--detections", detections, "--out", out)
    assert ends("ap", *usual, "--json") == IN_PART
    output = capsys.readouterr()
    assert "1 of 3 frames have no file" in output.err
    assert json.loads(output.out)["Car"]["3d"]["ap40"] == [2.5] * 3
    report = json.loads(out.read_text())
    assert report["labels"]["Car"] == {"easy": 3, "moderate": 3, "hard": 3}
    assert report["frames_without_detections"] == ["000001"]
    assert report["min_iou"]["Car"] == {"2d": 0.7, "bev": 0.7, "3d": 0.7, "aos": 0.7}
    assert report["precision"]["Car"]["3d"]["easy"][:3] == [1.0, 1.0, 0.0]
    printed = json.loads(output.out)
    assert (printed.pop("schema"), report["schema"]) == ("avsec.ap/1", "avsec.ap.report/1")
    assert report["average_precision"] == printed
    assert ends("ap", *usual) == BAD_DATA  # Nothing is overwritten.
    assert "report.json" in capsys.readouterr().err


@pytest.mark.parametrize("whose", ["labels", "detections"])
def test_a_broken_line_is_named_and_its_frame_left_out(
    whose: str, kitti: Path, detections: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = detections if whose == "detections" else kitti / "training" / "label_2"
    path = folder / "000003.txt"
    path.write_text(path.read_text() + "Car -1 -1 0 0 0 9\n")
    assert ends("ap", "--kitti", kitti, "--detections", detections, "--json") == IN_PART
    output = capsys.readouterr()
    assert f"{path}:2: " in output.err
    assert json.loads(output.out)["Car"]["3d"]["ap11"] == [ONE_OF_ELEVEN] * 3
    for other in folder.iterdir():
        other.write_text("Car 0 0\n")
    assert ends("ap", "--kitti", kitti, "--detections", detections, "--json") == BAD_DATA
    assert "000000.txt:1: " in capsys.readouterr().err


def test_what_is_not_there_is_refused(
    kitti: Path, detections: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    there = ("--kitti", kitti, "--detections", detections)
    assert ends("ap", "--kitti", tmp_path / "no", "--detections", detections) == BAD_DATA
    assert ends("ap", "--kitti", kitti, "--detections", tmp_path / "no") == BAD_DATA
    assert ends("ap", *there, "--split", "test") == BAD_DATA
    assert "ImageSets/test.txt" in capsys.readouterr().err
    for option in ("--limit", "--resamples", "--seed"):
        assert ends("ap", *there, option, -1) == BAD_USAGE
    assert ends("ap", *there, "--iou", "0.6") == BAD_USAGE
    assert ends("ap", "--kitti", kitti) == BAD_USAGE


def test_intervals_stand_beside_the_figures(
    kitti: Path, detections: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    usual = ("--kitti", kitti, "--detections", detections)
    plain, report, again = (
        scored(capsys, *usual, *more) for more in ((), ("--resamples", 50), ("--resamples", 50))
    )
    assert report == again
    for points in ("ap11", "ap40"):
        assert report["Car"]["3d"][points] == plain["Car"]["3d"][points]
        for value, (low, high) in zip(
            report["Car"]["3d"][points], report["Car"]["3d"][f"{points}_interval"], strict=True
        ):
            assert 0 <= low <= value <= high <= 100
    others = [scored(capsys, *usual, "--resamples", 2, "--seed", seed) for seed in range(4)]
    assert any(other != others[0] for other in others)
    # No pedestrian to find: no interval.
    assert report["Pedestrian"]["3d"]["ap11_interval"] == [[None, None]] * 3


def test_frames_of_one_drive_are_drawn_together(
    kitti: Path, detections: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    usual = ("--kitti", kitti, "--detections", detections, "--resamples", 400)
    alone = scored(capsys, *usual)["Car"]["3d"]["ap11_interval"]
    mapping = kitti / "mapping"
    mapping.mkdir()
    (mapping / "train_rand.txt").write_text("1,2,3,4")
    for drives, counted in ((("0001", "0001", "0002", "0002"), 2), (("0001",) * 4, 1)):
        lines = [
            f"2011_09_26 2011_09_26_drive_{drive}_sync {number:010d}"
            for number, drive in enumerate(drives)
        ]
        (mapping / "train_mapping.txt").write_text("\n".join(lines))
        assert ends("ap", *usual, "--json") == DONE
        output = capsys.readouterr()
        assert f"whole drives: the frames are of {counted}" in output.err
        found = json.loads(output.out)["Car"]["3d"]["ap11_interval"]
        if counted == 1:
            assert found == [[None, None]] * 3
            continue
        found_boxes = [cars(0)] * 3 + [cars(1, score=0.99)]
        result = average_precision(
            [cars(0)] * 4, found_boxes, classes=["Car"], resamples=400, together=drives
        )
        assert result.interval is not None
        assert found == pytest.approx(result.interval[0, 2, :, 0].round(4))
        assert found != alone


def test_the_lower_thresholds(
    kitti: Path, detections: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    short = replace(cars(0), dimensions=np.array([[1.5, 1.6, 2.4]]))  # IoU 0.6
    for path in detections.iterdir():
        write_detections(path, short, overwrite=True)
    usual = ("--kitti", kitti, "--split", "val", "--detections", detections)
    assert scored(capsys, *usual)["Car"]["3d"]["ap11"] == [0.0] * 3
    low = scored(capsys, *usual, "--iou", "low")
    assert low["Car"]["3d"]["ap11"] == low["Car"]["bev"]["ap11"] == [ONE_OF_ELEVEN] * 3


def test_the_table_and_the_picture(
    kitti: Path, detections: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    picture = tmp_path / "curves.png"
    usual = ("--kitti", kitti, "--detections", detections, "--figure", picture)
    assert ends("ap", *usual, "--resamples", 20) == DONE
    output = capsys.readouterr().out
    assert "4 frames" in output
    assert "AP11" in output
    assert "6.8 (" in output
    image = cv2.imread(str(picture))
    assert image.shape[1] > 1000
    assert (image != 255).any(axis=2).mean() > 0.01
    assert ends("ap", *usual) == BAD_DATA  # Nothing is overwritten.


def test_detections_without_2d_boxes_are_told(
    kitti: Path, detections: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_detections(detections / "000000.txt", replace(cars(0), box2d=None), overwrite=True)
    assert ends("ap", "--kitti", kitti, "--detections", detections, "--json") == DONE
    assert "1 detections have a 2D box without height" in capsys.readouterr().err


def test_the_safety_weighted_recall_stands_beside_the_precision_of_cars_where_it_is_asked_for(
    kitti: Path, detections: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The cars stand across the lane 20 m ahead, and one of four is missed."""
    usual = ("--kitti", kitti, "--detections", detections, "--safety-weighted")
    out = tmp_path / "report.json"
    report = scored(capsys, *usual, "--resamples", 200, "--out", out)
    found = report["Car"]["safety_weighted_recall"]
    assert found["recall"] == found["by_intention"]["straight"] == 0.75
    assert found["recall_interval"][0] < 0.75 < found["recall_interval"][1]
    assert (found["frames"], found["threshold"]) == (4, 0.3)
    assert "safety_weighted_recall" not in report["Pedestrian"]
    written = json.loads(out.read_text())["average_precision"]["Car"]
    assert written["safety_weighted_recall"] == found
    # Scores without bounds: everything from 0 on is planned on.
    write_detections(detections / "000003.txt", cars(0, score=0.1), overwrite=True)
    assert scored(capsys, *usual)["Car"]["safety_weighted_recall"]["recall"] == 0.75
    write_detections(detections / "000000.txt", cars(0, score=7.0), overwrite=True)
    assert scored(capsys, *usual)["Car"]["safety_weighted_recall"]["recall"] == 1.0
    assert ends("ap", *usual) == DONE
    assert "safety-weighted recall" in capsys.readouterr().out
