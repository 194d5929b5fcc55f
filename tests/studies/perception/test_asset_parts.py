"""Precision on two parts of the assets: intervals over scenes, and that of the difference."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from avsec_gym.experiments.json_rows import row_of
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.labels import parse_labels
from avsec_gym.kitti.writing import write_object_frame
from avsec_gym.metrics.average_precision import STANDARD_IOU, average_precision
from avsec_gym.rig import kitti_rig
from studies.perception.asset_parts import PartsPrecision, SeenScenes, parts_precision
from studies.perception.detector_precision import DetectorPrecision, main
from studies.perception.kept_detections import CarsToFind, LabelledData
from studies.perception.page import DetectorResults, page

CAR = "Car 0.00 0 -1.57 556.00 180.00 656.00 260.00 1.50 1.65 4.00 0.00 1.65 15.00 -1.57\n"
FRAMES = 60


def scenes(found: int, assets: str, seed: int) -> SeenScenes:
    """Frames with a car each, which is found in the first ones."""
    cars = parse_labels(CAR, "labels")
    boxes = [cars if number < found else cars[:0] for number in range(FRAMES)]
    data = LabelledData("mixed", seed, assets, "f", FRAMES, FRAMES, CarsToFind(*[FRAMES] * 4))
    return SeenScenes(data, [cars] * FRAMES, boxes)


def compared(judged: int, other: int, seed: int) -> PartsPrecision:
    parts = scenes(judged, "judge", 1), scenes(other, "train", seed)
    return parts_precision(*parts, STANDARD_IOU, 2000, 0)


def test_each_part_has_its_own_interval_and_so_has_the_difference() -> None:
    found = compared(30, 45, seed=2)
    for part, reached in ((found.judged, 30), (found.other, 45)):
        own = scenes(reached, "judge", 1)
        alone = average_precision(
            own.truth, own.found, classes=("Car",), min_iou=STANDARD_IOU, resamples=2000
        )
        assert part.value == pytest.approx(alone.value("Car"))
        assert alone.interval is not None
        assert part.interval == pytest.approx(alone.interval[0, 2, 1, 0])
    assert not found.paired
    value, (low, high) = found.difference.value, found.difference.interval or (0.0, 0.0)
    assert value == pytest.approx(found.judged.value - found.other.value)
    # Of independent scenes the variances of both parts add up, as far as steps of 1/11 show it.
    widths = [np.diff(part.interval)[0] for part in (found.judged, found.other)]
    assert high - low == pytest.approx(np.hypot(*widths), rel=0.25)
    assert low < value < high < 0


def test_equal_layouts_are_compared_one_by_one() -> None:
    """The same scenes are found in both parts: assets cost nothing, surely."""
    same = compared(30, 30, seed=1)
    assert same.paired
    assert (same.difference.value, same.difference.interval) == (0.0, [0.0, 0.0])
    apart = compared(30, 30, seed=2).difference.interval or (0.0, 0.0)
    assert apart[0] < -10 < 10 < apart[1]


def write_frames(root: Path, assets: str) -> None:
    images = {camera: np.full((375, 1242, 3), 90, np.uint8) for camera in (2, 3)}
    for number in range(2):
        frame = SensorFrame(f"{number:06d}", kitti_rig().calibration, images)
        write_object_frame(root / "training", frame, parse_labels(CAR, "labels"))
    settings = {"suite": "mixed", "seed": 5, "assets": assets}
    manifest = {"format": 1, "complete": True, "settings": settings, "files": {}}
    (root / "manifest.json").write_text(json.dumps(manifest))


def run(tmp_path: Path, other: str) -> tuple[int, dict[str, Any]]:
    out = tmp_path / "result.json"
    arguments = [
        "--kitti", tmp_path / "judge", "--other-part", tmp_path / other, "--json", out, "--out",
        tmp_path / "found", "--resamples", 10, "--timed", 1, "--detectors", "oracle",
    ]  # fmt: skip
    code = main(list(map(str, arguments)))
    return code, json.loads(out.read_text()) if out.exists() else {}


def test_the_study_compares_parts(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    for assets in ("judge", "train"):
        write_frames(tmp_path / assets, assets)
    code, result = run(tmp_path, "train")
    assert code == 0
    assert result["other_part"]["assets"] == "train"
    parts = result["detectors"]["oracle"]["parts"]["0.7"]
    assert parts["judged"] == parts["other"]
    assert (parts["difference"], parts["paired"]) == (0.0, True)
    text = page(DetectorResults(row_of(DetectorPrecision, result)))
    assert "## By assets" in text
    assert "| judging assets | training assets | difference |" in text
    assert run(tmp_path, "judge")[0] == 1
    assert "both of the assets 'judge'" in caplog.text


def test_frames_that_networks_learn_from_are_judged_only_if_that_is_meant(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    write_frames(tmp_path / "train", "train")
    given = [
        "--kitti", tmp_path / "train", "--json", tmp_path / "result.json", "--out",
        tmp_path / "found", "--resamples", 0, "--timed", 1, "--detectors", "oracle",
    ]  # fmt: skip
    words = list(map(str, given))
    assert main(words) == 1
    assert "are of the assets 'train', which networks learn from" in caplog.text
    assert not (tmp_path / "found").exists()
    assert main([*words, "--any-assets"]) == 0
