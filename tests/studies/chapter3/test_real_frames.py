"""Attacks on a real frame, by thresholds that are given."""

from __future__ import annotations

import json
from argparse import Namespace
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.json_rows import row_json
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import transform_points
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.metrics.clustered_shares import share_of
from avsec_gym.validation.detection import LIDAR_AND_TWO_CAMERAS
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.fitted_on import fitted_on
from avsec_gym.validation.thresholds import ThresholdTable
from studies.chapter3 import real_impact
from studies.chapter3.real_frames import detected, run
from studies.chapter3.real_frames_page import main, real_frames_page
from studies.chapter3.real_frames_result import DetectionOnFrame, FittedSuite, RealFramesResult
from studies.chapter3.real_impact import impact_on_real_frames


def test_light_into_real_cameras_is_detected(shared: Path) -> None:
    frame = KittiObject(shared / "kitti" / "object").frame("000107")
    depth = PairDepth("sgbm")
    on = fitted_on(LIDAR_AND_TWO_CAMERAS, depth, frame.calibration, {"made": "up"})
    usual = ThresholdTable(on, np.array([[[0.25, 0.3, 0.05, 0.01]]]))
    found = detected(frame, usual, depth, 0.01, draws=2)
    assert found.false_alarm == {"any": False, "error": False}
    assert 0 < found.clean["error"] < 0.25
    assert list(found.cases) == ["S0", "S1", "S0+S1", "S2", "S0+S2", "S1+S2", "S0+S1+S2"]
    for case in ("S1", "S2", "S0+S1+S2"):
        assert found.cases[case]["any"].count == 2
    # Whoever is beyond no threshold at all detects nothing.
    deaf = ThresholdTable(on, np.ones((1, 1, 4)))
    assert not any(
        case["any"].count for case in detected(frame, deaf, depth, 0.01, 1).cases.values()
    )


def test_no_draws() -> None:
    with pytest.raises(ConfigurationError, match="--draws"):
        run(Namespace(draws=0, kitti=Path("nowhere"), rate=0.01))


class Believer:
    """Knows the labels, and sees a car at any points that are not in the file."""

    name = "believer"

    def __init__(self, data: KittiObject) -> None:
        self._data = data

    def detect(self, frame: SensorFrame) -> Boxes3D:
        labels = self._data.labels(frame.id)
        known = replace(labels, score=np.full(len(labels), 0.6), truncation=None, occlusion=None)
        clean = {tuple(point) for point in self._data.frame(frame.id).points.tolist()}
        strange = [point[:3] for point in frame.points.tolist() if tuple(point) not in clean]
        if not strange:
            return known
        places = transform_points(frame.calibration.velodyne_to_camera, np.array(strange))
        x, _, z = places.mean(axis=0)
        bogus = Boxes3D(
            [[x, 1.65, z]], [[1.5, 6.0, 6.0]], [0.0], [0.9], ["Car"],
            box2d=[[0.0, 0, 99, 99]], alpha=[0.0],
        )  # fmt: skip
        return Boxes3D.concatenate([known, bogus])


class Window:
    """Knows the labels, and sees none once the image is brighter."""

    name = "window"

    def __init__(self, data: KittiObject) -> None:
        self._data = data

    def detect(self, frame: SensorFrame, camera: int) -> Boxes3D:
        labels = self._data.labels(frame.id)
        known = replace(labels, score=np.full(len(labels), 0.6), truncation=None, occlusion=None)
        clean = self._data.frame(frame.id).image(camera)
        return known if (frame.image(camera) == clean).all() else known[:0]


@pytest.mark.slow
def test_detectors_are_led_astray_on_real_frames(
    shared: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    data = KittiObject(shared / "kitti" / "object")
    monkeypatch.setattr(real_impact, "lidar_detector", lambda name, options: Believer(data))
    monkeypatch.setattr(real_impact, "image_detector", lambda name, options: Window(data))
    found = impact_on_real_frames(data, data, draws=2)
    scans, images = found.pixor, found.yolo
    assert scans is not None
    assert images is not None
    for impact in (scans, found.pointrcnn, found.faster_rcnn, images):
        assert impact is not None
        assert impact.score == 0.6
    assert (len(scans.frames), len(images.frames)) == (8, 13)
    for share in (scans.taken, scans.car_taken):
        assert share is not None
        assert (share.count, share.of) == (16, 16)
    assert scans.already.percent < 50
    assert images.found.rate == 1.0
    assert images.found_attacked.rate == 0.0
    assert images.found_attacked.of == 2 * images.found.of
    assert images.false_alarms == images.false_alarms_attacked == 0.0
    on_frame = DetectionOnFrame(
        clean={},
        false_alarm={"any": False, "error": True},
        cases={"S0": dict.fromkeys(("any", "error"), scans.taken)},
    )
    result = RealFramesResult(
        FittedSuite("mixed", 48), 0.01, 2, thresholds={}, frames={"000107": on_frame}, impact=found
    )
    given, written = tmp_path / "result.json", tmp_path / "page.md"
    given.write_text(json.dumps(row_json(result)))
    assert main([str(given), "--out", str(written)]) == 0
    page = written.read_text()
    assert "| LiDAR | 100.0 [" in page
    assert "| no attack | no alarm | a false alarm |" in page
    assert "| YOLOv3 | 13 | 100.0 [" in page
    assert "*98.6*" in page
    # What could not be counted is told as unknown.
    unjudged = replace(images, found_attacked=share_of([], []))
    page = real_frames_page(replace(result, impact=replace(found, pixor=None, yolo=unjudged)))
    assert "PIXOR |" not in page
    assert "| YOLOv3 | 13 | 100.0 [" in page
    assert "] | – | 0.00" in page
    given.write_text("{}")
    assert main([str(given), "--out", str(written)]) == 1


def test_frames_without_labels_are_attacked_all_the_same(shared: Path, tmp_path: Path) -> None:
    data = KittiObject(shared / "kitti" / "object")
    assert data.folder.is_dir()
    bare = tmp_path / "training"
    for name in ("calib", "image_2", "velodyne"):
        (bare / name).mkdir(parents=True)
        for file in sorted((data.folder / name).glob("000000.*")):
            (bare / name / file.name).symlink_to(file)
    found = impact_on_real_frames(KittiObject(tmp_path), data, draws=1)
    assert row_json(found) == dict.fromkeys(("pixor", "pointrcnn", "faster_rcnn", "yolo"))
