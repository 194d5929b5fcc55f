"""Twins of labelled frames; here of our own, so that no KITTI is needed."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.kitti import KittiObject, read_labels, write_labels
from avsec_gym.world.export import Twins, make_data_set
from avsec_gym.world.export.twins import twin_ids, twin_rig


@pytest.fixture(scope="module")
def labelled(mixed: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two cars in a row and one hidden behind them; a frame with a broken label."""
    root = tmp_path_factory.mktemp("labelled")
    for kind in ("calib", "image_2"):
        shutil.copytree(mixed / "training" / kind, root / "training" / kind)
    boxes = Boxes3D(
        np.array([[0.5, 1.7, 20.0], [-4.0, 1.6, 12.0], [0.5, 1.7, 8.0]]),
        np.array([[1.2, 1.5, 3.5], [1.53, 1.6, 3.9], [2.4, 2.1, 6.0]]),
        np.array([-1.57, 1.5, -1.57]),
        np.ones(3),
        np.array(["Car", "Car", "Van"]),
    )
    write_labels(root / "training/label_2/000000.txt", boxes)
    (root / "training/label_2/000001.txt").write_text("Car 0.0 what\n")
    return root


def test_same_objects_in_the_same_order(labelled: Path, tmp_path: Path) -> None:
    report = make_data_set(Twins(labelled, ("000000", "000001")), tmp_path, workers=1)
    assert (report.made, report.left_out) == (1, 1)
    hidden, broken = report.remarks
    assert hidden == "000000: not seen in the twin: Car (object 1)"
    assert broken.startswith("left out")
    assert "000001.txt:1" in broken
    twin, original = KittiObject(tmp_path), KittiObject(labelled)
    boxes, real = twin.labels("000000"), original.labels("000000")[1:]
    assert boxes.category.tolist() == real.category.tolist()
    for name in ("location", "dimensions", "rotation_y"):
        np.testing.assert_array_equal(getattr(boxes, name), getattr(real, name))
    assert boxes.occlusion is not None
    assert boxes.occlusion[1] == 0
    assert twin.frame("000000").image(2).shape == original.frame("000000").image(2).shape
    calibrations = [root / "training/calib/000000.txt" for root in (tmp_path, labelled)]
    assert calibrations[0].read_bytes() == calibrations[1].read_bytes()
    scene = json.loads((tmp_path / "training/scene/000000.json").read_text())
    assert scene["hidden"] == [0]


def test_the_camera_stands_above_the_objects_close_by(labelled: Path) -> None:
    data = KittiObject(labelled)
    boxes = data.labels("000000")
    assert twin_rig(data, "000000", boxes).camera_height == pytest.approx(1.7)
    assert twin_rig(data, "000000", boxes[:1]).camera_height == 1.65
    assert twin_rig(data, "000000", boxes).size == (414, 125)


def test_frames_are_chosen(labelled: Path) -> None:
    data = KittiObject(labelled)
    assert twin_ids(data, (), None) == ("000000", "000001")
    assert twin_ids(data, ("000001",), None) == ("000001",)
    with pytest.raises(ConfigurationError, match="no label and calibration of 000007"):
        twin_ids(data, ("000007",), None)
    with pytest.raises(ConfigurationError, match="not both"):
        twin_ids(data, ("000001",), "val")
    with pytest.raises(ConfigurationError, match="six digits"):
        Twins(labelled, ("7",))


def test_a_twin_of_a_real_frame(shared: Path, tmp_path: Path) -> None:
    real = shared / "kitti/object"
    make_data_set(Twins(real, ("000107",), cameras=(2,), lidar=False), tmp_path, workers=1)
    label = "training/label_2/000107.txt"
    boxes, twins = read_labels(real / label), read_labels(tmp_path / label)
    kept = [
        int(np.flatnonzero((boxes.location == place).all(axis=1))[0]) for place in twins.location
    ]
    assert kept == sorted(kept)
    assert len(kept) >= len(boxes) - 2
    assert boxes.box2d is not None
    assert twins.box2d is not None
    # Boxes of annotators hug 3D boxes, those of twins hug objects.
    np.testing.assert_allclose(twins.box2d, boxes.box2d[kept], atol=30)
