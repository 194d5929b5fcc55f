"""Boxes without a place in space: in result files, and scored in the image alone."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.kitti.labels import read_detections, write_detections
from avsec_gym.metrics.average_precision import average_precision
from avsec_gym.perception.detectors import make_image_detector
from avsec_gym.perception.detectors.faster_rcnn.configuration import SMALL as FASTER_RCNN
from avsec_gym.perception.detectors.image_detector import image_boxes
from avsec_gym.perception.detectors.yolo.configuration import SMALL as YOLO

BOX = np.array([[100.0, 150, 180, 210]])
TRUTH = Boxes3D(
    [[2.0, 1.6, 14]], [[1.5, 1.6, 4.0]], [0.3], np.ones(1), ["Car"],
    box2d=BOX, truncation=np.zeros(1), occlusion=np.zeros(1), alpha=np.zeros(1),
)  # fmt: skip


def test_result_files_keep_them_and_only_the_image_is_scored(tmp_path: Path) -> None:
    path = tmp_path / "000000.txt"
    write_detections(path, image_boxes(BOX, np.array([0.8]), ["Car"]))
    found = read_detections(path)
    np.testing.assert_array_equal(found.box2d, BOX)
    # With fewer labels than recall points, KITTI's precision stays below 100.
    result = average_precision([TRUTH] * 41, [found] * 41, classes=("Car",))
    values = {name: result.value("Car", name) for name in ("2d", "bev", "3d")}
    assert values == pytest.approx({"2d": 100, "bev": np.nan, "3d": np.nan}, nan_ok=True)
    assert np.isnan(result.value("Car", "aos"))


def test_nothing_found_is_no_boxes() -> None:
    empty = image_boxes(np.zeros((0, 4)), np.zeros(0), [])
    assert len(empty) == 0
    assert average_precision([TRUTH], [empty], classes=("Car",)).value("Car", "2d") == 0


@pytest.mark.parametrize(("name", "small"), [("faster_rcnn", FASTER_RCNN), ("yolo", YOLO)])
def test_missing_weights_name_the_command_that_trains_them(
    name: str, small: Any, tmp_path: Path
) -> None:
    with pytest.raises(DataError, match=r"nowhere\.safetensors: There are no.*avsec train"):
        make_image_detector({"name": name, "weights": str(tmp_path / "nowhere.safetensors")})
    unshipped = replace(small, name="own")
    with pytest.raises(DataError, match=rf"No weights of {name}_own come with.*avsec train"):
        make_image_detector({"name": name, "configuration": unshipped})


def test_a_stereo_detector_is_none_of_images() -> None:
    with pytest.raises(ConfigurationError, match="faster_rcnn, yolo"):
        make_image_detector("dsgn")
