"""2D boxes drive no car: every door that detections come in by, and every way files write them."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from avsec_gym import registry
from avsec_gym.boxes import Boxes3D
from avsec_gym.cli import run
from avsec_gym.envs.box_coding import BoxCoding
from avsec_gym.envs.detector_policy import DetectorPolicy
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.image_only import is_image_only
from avsec_gym.kitti.detections import DetectionFolder
from avsec_gym.kitti.labels import read_detections, write_detections, write_labels
from avsec_gym.metrics.average_precision import average_precision
from avsec_gym.perception.detectors.image_detector import image_boxes
from avsec_gym.pipeline import Pipeline, run_episode
from avsec_gym.registry import Kind
from avsec_gym.rig import kitti_rig
from avsec_gym.scenario.scene_sets import procedural_scenes

IMAGE = "500.00 150.00 700.00 300.00"
IN_SPACE = f"Car -1 -1 -1.57 {IMAGE} 1.5 1.6 4.0 0.0 1.65 12.0 -1.57 0.9"
FORMS = {
    "KITTI's": f"Car -1 -1 -10 {IMAGE} -1 -1 -1 -1000 -1000 -1000 -10 0.9",
    "with decimals": f"Car -1.00 -1 -10.00 {IMAGE} -1.00 -1.00 -1.00 -1000.0 -1000.0 -1000.0 -10 1",
    "sizes alone": f"Car 0.0 0 -10 {IMAGE} -1 -1 -1 -1 -1 -1 -1 0.9",
    "zeros": f"Car 0.0 0 0.0 {IMAGE} 0.0 0.0 0.0 0.0 0.0 0.0 0.0 0.9",
    "of earlier releases": f"Car -1 -1 -10 {IMAGE} 0.01 0.01 0.01 -1000.0 -1000.0 -1000.0 -10 1",
}
IDS = ("000000", "000001")
CAR = Boxes3D(
    np.array([[0.0, 1.65, 12.0]]),
    np.array([[1.5, 1.6, 4.0]]),
    np.array([-1.57]),
    np.ones(1),
    np.array(["Car"]),
    box2d=np.array([[500.0, 150, 700, 300]]),
    truncation=np.zeros(1),
    occlusion=np.zeros(1),
    alpha=np.array([-1.57]),
)


def nowhere(count: int = 1) -> Boxes3D:
    return image_boxes(np.tile(CAR.box2d, (count, 1)), np.full(count, 0.9), ["Car"] * count)


@pytest.fixture
def kitti(tmp_path: Path) -> Path:
    """Two labelled frames with a car ahead in each."""
    root = tmp_path / "kitti"
    for id in IDS:
        write_labels(root / "training" / "label_2" / f"{id}.txt", CAR)
    return root


def results(folder: Path, *lines: str) -> Path:
    """A result folder: these lines in the first frame, a car in space in the second."""
    folder.mkdir()
    (folder / "000000.txt").write_text("\n".join(lines) + "\n")
    (folder / "000001.txt").write_text(IN_SPACE + "\n")
    return folder


@pytest.mark.parametrize("line", FORMS.values(), ids=FORMS)
@pytest.mark.parametrize("also", [(), (IN_SPACE,)], ids=["alone", "beside a car in space"])
def test_no_folder_with_2d_boxes_is_driven_by(
    kitti: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], line: str, also: tuple[str]
) -> None:
    folder = results(tmp_path / "results", line, *also)
    evaluate = ["evaluate", "--kitti", str(kitti), "--detections", str(folder)]
    assert run([*evaluate, "--out", str(tmp_path / "out")]) == 1
    error = " ".join(capsys.readouterr().err.split())
    assert f"1 of {2 + len(also)} detections have no 3D box" in error
    assert folder.name in error
    assert "000000" in error
    assert "avsec ap" in error
    assert not (tmp_path / "out").exists()
    draw = ["draw", "000000", "--scenarios", str(kitti / "training" / "label_2")]
    assert run([*draw, "--kitti", str(kitti), "--detections", str(folder)]) == 1
    with pytest.raises(DataError, match="no 3D box"):
        DetectionFolder(folder).read(IDS)
    replayed = registry.make(Kind.DETECTOR, {"name": "replayed", "detections": str(folder)})
    with pytest.raises(DataError, match="no 3D box"):
        replayed.detect(SensorFrame("000000", kitti_rig().calibration))
    assert len(replayed.detect(SensorFrame("000001", kitti_rig().calibration))) == 1


@pytest.mark.parametrize("line", FORMS.values(), ids=FORMS)
def test_every_form_is_read_as_the_same_box_and_written_as_kitti_does(
    tmp_path: Path, line: str
) -> None:
    folder = results(tmp_path / "results", line, IN_SPACE)
    found = read_detections(folder / "000000.txt")
    assert is_image_only(found).tolist() == [True, False]
    same = nowhere()
    for name in ("location", "dimensions", "rotation_y", "box2d"):
        assert getattr(found[:1], name).tolist() == getattr(same, name).tolist()
    again = tmp_path / "again.txt"
    write_detections(again, found)
    assert again.read_text().split()[8:15] == ["-1"] * 3 + ["-1000"] * 3 + ["-10"]
    assert read_detections(again).location.tolist() == found.location.tolist()


@pytest.mark.parametrize("sizes", ["-1 1.6 4.0", "0 1.6 4.0", "-2 -2 -2", "1.5 1.6 -1"])
def test_other_sizes_that_cannot_be_are_still_refused(tmp_path: Path, sizes: str) -> None:
    path = tmp_path / "000000.txt"
    path.write_text(f"Car -1 -1 -10 {IMAGE} {sizes} 0.0 1.65 12.0 -1.57 0.9\n")
    with pytest.raises(DataError, match="measures"):
        read_detections(path)


class Seer:
    """A detector of one's own that finds 2D boxes and does not say so."""

    name = "seer"

    def detect(self, frame: SensorFrame) -> Boxes3D:
        return nowhere()


def test_no_pipeline_and_no_policy_drives_by_them(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = procedural_scenes(1).scenes[0]
    with pytest.raises(ConfigurationError, match="image only"):
        run_episode(scene, believed=nowhere())
    with pytest.raises(ConfigurationError, match="image only"):
        run_episode(scene, believed=Boxes3D.concatenate([CAR, nowhere()]))
    frame = SensorFrame("000000", kitti_rig().calibration)
    with pytest.raises(ConfigurationError, match="image only"):
        Pipeline(Seer())(scene, frame)
    with pytest.raises(ConfigurationError, match="image only"):
        BoxCoding().encode(nowhere())

    class Declared(Seer):
        image_only = True

    monkeypatch.setitem(registry._REGISTERED, (Kind.IMAGE_DETECTOR, "seer"), Seer)
    single: dict[str, Any] = {"name": "single_image", "detector": "seer"}
    for detector in (single, Declared()):
        for made in (Pipeline, DetectorPolicy):
            with pytest.raises(ConfigurationError, match="2D boxes in one image"):
                made(detector)


def test_precision_is_that_of_the_image_alone(
    kitti: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "results"
    for id in IDS:
        write_detections(folder / f"{id}.txt", nowhere())
    command = ["ap", "--kitti", str(kitti), "--detections", str(folder)]
    assert run([*command, "--json"]) == 0
    shown = capsys.readouterr()
    precision = json.loads(shown.out)["Car"]
    assert "only the image is scored" in " ".join(shown.err.split())
    assert precision["2d"]["ap11"][0] > 0
    assert precision["bev"]["ap11"] == precision["3d"]["ap40"] == [None] * 3
    assert run(command) == 0
    table = capsys.readouterr().out
    assert "2d" in table
    assert "bev" not in table
    assert "3d" not in table

    write_detections(folder / "000001.txt", CAR, overwrite=True)
    assert run([*command, "--json"]) == 0
    shown = capsys.readouterr()
    assert "1 of 2 detections have no 3D box" in " ".join(shown.err.split())
    assert json.loads(shown.out)["Car"]["3d"]["ap11"][0] is not None


def test_a_class_without_a_place_in_space_leaves_the_others_alone() -> None:
    walker = replace(nowhere(), category=np.array(["Pedestrian"]))
    found = Boxes3D.concatenate([CAR, walker])
    result = average_precision([CAR], [found], resamples=3)
    assert np.isnan(result.precision[1, 1:3]).all()
    assert result.value("Car", "3d") > 0
    assert result.value("Cyclist", "3d") == 0
    assert result.drawn is not None
    assert np.isnan(result.drawn[1, 1:3]).all()
