from __future__ import annotations

from pathlib import Path

import pytest

from avsec_gym.kitti.check import check_data
from avsec_gym.kitti.layouts import KittiLayout


@pytest.mark.parametrize(
    ("files", "name"),
    [
        (["data_2d_raw/2013_05_28_drive_0000_sync/image_00/data_rect/0000000000.png"], "KITTI-360"),
        (["v1.0-mini/sample.json", "samples/LIDAR_TOP/a.pcd.bin"], "nuScenes"),
        (["validation/segment-1_with_camera_labels.tfrecord"], "Waymo Open"),
        (["train/0f0c/city_SE3_egovehicle.feather"], "Argoverse"),
        (["argoverse-tracking/train1/x/vehicle_calibration_info.json"], "Argoverse"),
    ],
)
def test_recognised_with_the_way_by_result_folders(
    tmp_path: Path, files: list[str], name: str
) -> None:
    for file in files:
        (tmp_path / "set" / file).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "set" / file).touch()
    report = check_data(tmp_path / "set")
    assert report.layout is KittiLayout.UNKNOWN
    assert not report.ok
    advice = report.notes[1]
    assert advice.startswith(f"This is {name}, which is not read.")
    assert "avsec evaluate --scenarios LABELS --detections RESULTS" in advice
    above = check_data(tmp_path).notes
    assert any(note.startswith(f"In its subfolder set/: This is {name}") for note in above)


def test_nothing_else_is_taken_for_one(tmp_path: Path, raw_root: Path) -> None:
    (tmp_path / "photos" / "samples").mkdir(parents=True)
    for root in (tmp_path / "photos", raw_root):
        assert not any("which is not read" in note for note in check_data(root).notes)
