"""Detectors of one sensor: scored in what it lets them tell."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import DataError
from avsec_gym.experiments.json_rows import row_of
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.labels import parse_labels
from avsec_gym.kitti.writing import write_object_frame
from avsec_gym.metrics.working_point import Counts
from avsec_gym.perception.detectors.pixor.detector import PixorDetector
from avsec_gym.perception.detectors.yolo.detector import YoloDetector
from avsec_gym.perception.weights.model_card import ModelCard
from avsec_gym.perception.weights.store import save_weights
from avsec_gym.rig import kitti_rig
from studies.perception import single_sensor_precision
from studies.perception.page_single_sensor import single_sensor
from studies.perception.single_sensor_precision import (
    NETWORKS,
    RealFrames,
    SingleSensorPrecision,
    in_real_frames,
    main,
)

LABELS = "Car 0.00 0 -1.57 556.00 180.00 656.00 260.00 1.50 1.65 4.00 0.00 1.65 15.00 -1.57\n"


@pytest.fixture
def kitti(tmp_path: Path) -> Path:
    root = tmp_path / "kitti"
    rng = np.random.default_rng(0)
    for number in range(2):
        images = {2: rng.integers(0, 256, (375, 1242, 3), np.uint8)}
        points = rng.uniform((5, -10, -1.7, 0), (40, 10, 0, 1), (500, 4)).astype(np.float32)
        frame = SensorFrame(f"{number:06d}", kitti_rig().calibration, images, points)
        write_object_frame(root / "training", frame, parse_labels(LABELS, "labels"))
    return root


def run(kitti: Path, tmp_path: Path, *detectors: str) -> Any:
    out = tmp_path / "result.json"
    arguments = ["--kitti", kitti, "--json", out, "--out", tmp_path / "found", "--resamples", 10]
    assert main([*map(str, arguments), "--timed", "1", "--detectors", *detectors]) == 0
    return json.loads(out.read_text())


def test_each_is_scored_in_what_its_sensor_shows(kitti: Path, tmp_path: Path) -> None:
    torch.manual_seed(0)
    files = {}
    for name, network in (("pixor", PixorDetector().network), ("yolo", YoloDetector().network)):
        files[name] = tmp_path / f"{name}.safetensors"
        save_weights(files[name], network, ModelCard(name))
    asked = [f"{name}={file}" for name, file in files.items()]
    result = run(kitti, tmp_path, *asked)
    assert list(result["detectors"]) == ["pixor", "yolo"]
    for name, figures in result["detectors"].items():
        assert list(figures["average_precision"]) == ["0.7", "0.5"]
        for precision in figures["average_precision"].values():
            assert tuple(precision) == NETWORKS[name].metrics
        assert figures["weights"]["network"] == name
    assert result["data"]["cars"]["moderate"] == 2
    read = row_of(SingleSensorPrecision, result)
    text = "\n".join(single_sensor(read))
    assert "| `pixor` | LiDAR | from above |" in text
    assert "| `yolo` | camera 2 | in the image |" in text
    assert "None" not in text
    assert {path.name.partition("-")[0] for path in (tmp_path / "found").iterdir()} == set(files)
    # Frames of the procedural world are made by the command that the page shows.
    data = replace(read.data, suite="mixed", seed=7, assets="judge", frames=20)
    text = "\n".join(single_sensor(replace(read, data=data)))
    assert "avsec world make --suite mixed --frames 20 --seed 7 --assets judge --out DIR" in text
    assert "seed 7, judging assets)" in text


class Knows:
    """Says that there is a car where the labels say it, and another one beside it."""

    name = "knows"

    def detect(self, frame: SensorFrame) -> Boxes3D:
        car = parse_labels(LABELS, "labels")
        aside = replace(car, location=car.location - [10.0, 0.0, 0.0], score=np.array([0.4]))
        return Boxes3D.concatenate([replace(car, score=np.array([0.9])), aside])


def test_real_frames_are_counted_from_a_score_on(
    kitti: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(single_sensor_precision, "make_detector", lambda what: Knows())
    (kitti / "training/velodyne/000001.bin").unlink()
    for least, false_alarms in ((0.3, 1), (0.5, 0)):
        seen = in_real_frames(kitti, NETWORKS["pixor"], {"name": "pixor"}, least)
        counts = Counts(found=1, missed=0, false_alarms=false_alarms)
        assert seen == RealFrames(["000000"], counts, Counts(found=1, missed=0, false_alarms=1))
    images = in_real_frames(kitti, NETWORKS["yolo"], {"name": "yolo"}, 0.5).frames
    assert images == ["000000", "000001"]
    (kitti / "training/velodyne/000000.bin").unlink()
    with pytest.raises(DataError, match="velodyne"):
        in_real_frames(kitti, NETWORKS["pixor"], {"name": "pixor"}, 0.5)


def test_bad_input_is_told(kitti: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    assert main(["--kitti", str(kitti), "--detectors", "dsgn"]) == 1
    assert "none of pixor, pointrcnn, faster_rcnn, yolo" in caplog.text
    assert main(["--kitti", str(kitti), "--detectors", f"yolo={tmp_path / 'none'}"]) == 1
    assert "There are no weights" in caplog.text
    assert main(["--kitti", str(tmp_path / "nowhere")]) == 1
    assert main(["--kitti", str(kitti), "--timed", "0"]) == 1
