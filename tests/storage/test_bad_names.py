"""Names that no file can have are clear errors from Python, too, wherever a path is taken."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from avsec_gym.attacks.object_scan import read_object_scan
from avsec_gym.attacks.patch_files import load_patch
from avsec_gym.errors import DataError
from avsec_gym.kitti import (
    calibration,
    check,
    dataset,
    detections,
    label_folders,
    labels,
    map_files,
    oxts,
    raw,
    sensor_files,
    splits,
    timestamps,
    tracking,
    tracklets,
)
from avsec_gym.perception.weights.published import published_state
from avsec_gym.perception.weights.torch_files import read_torch_file
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.scenario.scene_sets import label_folder, labelled_scenarios
from avsec_gym.validation.thresholds import read_threshold_table
from avsec_gym.world.export import changed_files

READERS: dict[str, Callable[[Path], Any]] = {
    "labels": labels.read_labels,
    "detections": labels.read_detections,
    "label folder": label_folders.read_label_folder,
    "detection folder": detections.DetectionFolder,
    "calibration": calibration.read_calibration,
    "object data": dataset.KittiObject,
    "raw data": raw.KittiRaw,
    "drive": raw.Drive,
    "check": check.check_data,
    "split": splits.read_split,
    "image": sensor_files.read_image,
    "image size": sensor_files.read_image_size,
    "scan": sensor_files.read_points,
    "disparity": map_files.read_disparity,
    "mask": map_files.read_mask,
    "oxts": oxts.read_oxts,
    "timestamps": timestamps.read_timestamps,
    "tracking": tracking.read_tracking_labels,
    "tracklets": tracklets.read_tracklets,
    "object scan": read_object_scan,
    "patch": load_patch,
    "published weights": published_state,
    "torch file": lambda path: read_torch_file(path, remedy=""),
    "run": RunFolder.open,
    "thresholds": read_threshold_table,
    "data set": changed_files,
    "scenes": labelled_scenarios,
    "labelled scenes": label_folder,
}


@pytest.mark.parametrize("name", ["n" * 300, "a\0b", "absent", "/".join(["deep"] * 2000)])
@pytest.mark.parametrize("reader", READERS.values(), ids=READERS.keys())
def test_a_bad_name_is_a_clear_error(
    tmp_path: Path, reader: Callable[[Path], Any], name: str
) -> None:
    with pytest.raises(DataError) as caught:
        reader(tmp_path / name)
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 3000
