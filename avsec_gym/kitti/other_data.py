"""Data sets that are not read, recognised by the form of their folders, and the way round."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class OtherData:
    """A data set of others.

    Args:
        name: Name of the data set.
        signs: Patterns of paths below its root; it is this data set where one of the groups is
            there in full.
        converter: What writes its frames in KITTI's object layout, a sentence; empty where
            nothing is known to.
    """

    name: str
    signs: Sequence[tuple[str, ...]]
    converter: str = ""

    @property
    def advice(self) -> str:
        """That it is not read, and what can be done all the same."""
        return (
            f"This is {self.name}, which is not read. A detector can be judged on it by folders in "
            "KITTI's formats: true boxes as label files (15 columns) in LABELS/, its detections as "
            "result files (16 columns) in RESULTS/, both named by six digits, then `avsec evaluate "
            f"--scenarios LABELS --detections RESULTS`. {self.converter}"
        ).rstrip()


OTHER_DATA = (
    OtherData(
        "KITTI-360",
        (("data_2d_raw",), ("data_3d_raw",), ("data_3d_bboxes",), ("2013_05_28_drive_*_sync",)),
    ),
    OtherData(
        "nuScenes",
        (("v1.0-*", "samples"), ("v1.0-*/sample_annotation.json",), ("sample_annotation.json",)),
        "The nuScenes devkit's export_kitti.py writes such files.",
    ),
    OtherData(
        "Waymo Open",
        (
            ("*.tfrecord",),
            ("training/*.tfrecord",),
            ("validation/*.tfrecord",),
            ("camera_image", "lidar"),
            ("training/camera_image", "training/lidar"),
        ),
        "mmdetection3d's converter of Waymo data (`tools/create_data.py waymo`) writes such files.",
    ),
    OtherData(
        "Argoverse",
        (
            ("argoverse-tracking",),
            ("*/vehicle_calibration_info.json",),
            ("*/*/vehicle_calibration_info.json",),
            ("city_SE3_egovehicle.feather",),
            ("*/city_SE3_egovehicle.feather",),
            ("*/*/city_SE3_egovehicle.feather",),
            ("*/scenario_*.parquet",),
            ("*/*/scenario_*.parquet",),
        ),
    ),
)


def other_data(root: Path) -> OtherData | None:
    """Which of them a folder is, None where it is none; only names are looked at."""
    for data in OTHER_DATA:
        for group in data.signs:
            if all(next(root.glob(sign), None) is not None for sign in group):
                return data
    return None
