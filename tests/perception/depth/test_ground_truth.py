"""True disparities beside a frame's image."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from avsec_gym.errors import DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.kitti.map_files import write_disparity
from avsec_gym.kitti.writing import write_object_frame
from avsec_gym.perception.depth.ground_truth import GroundTruthDepth
from avsec_gym.rig import kitti_rig


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    image = np.zeros((20, 30, 3), np.uint8)
    frame = SensorFrame("000007", kitti_rig().calibration, {2: image, 3: image})
    write_object_frame(tmp_path / "training", frame)
    return tmp_path


def test_the_file_is_the_truth(folder: Path) -> None:
    disparity = np.full((20, 30), 12.5, np.float32)
    disparity[0] = np.nan
    write_disparity(folder / "training" / "disparity_2" / "000007.png", disparity)
    found = GroundTruthDepth().disparity(KittiObject(folder).frame("000007"))
    np.testing.assert_array_equal(found.values, disparity)
    calibration = kitti_rig().calibration
    assert found.depth[5, 5] == pytest.approx(
        calibration.focal_length(2) * calibration.baseline(2, 3) / 12.5
    )


def test_without_a_file_the_frame_and_the_remedy_are_named(folder: Path) -> None:
    with pytest.raises(DataError, match=r"000007.*avsec world make"):
        GroundTruthDepth().disparity(KittiObject(folder).frame("000007"))
    with pytest.raises(DataError, match=r"no folder"):
        GroundTruthDepth().disparity(SensorFrame("000007", kitti_rig().calibration))
