"""Which of KITTI's layouts a folder has, recognised by the names in it."""

from __future__ import annotations

import os
from enum import StrEnum
from pathlib import Path

from avsec_gym.errors import DataError
from avsec_gym.kitti.dataset import layout_folders
from avsec_gym.kitti.label_folders import frame_ids
from avsec_gym.kitti.odometry import odometry_folder
from avsec_gym.kitti.raw import find_raw
from avsec_gym.kitti.stereo import stereo_layout
from avsec_gym.kitti.tracking_sequences import LABELS, sequence_names
from avsec_gym.storage.regular_files import is_folder
from avsec_gym.storage.text_files import read_text


class KittiLayout(StrEnum):
    """What a folder was recognised as."""

    OBJECT = "object"
    DETECTIONS = "detections"
    LABELS = "labels"
    RAW = "raw"
    TRACKING = "tracking"
    ODOMETRY = "odometry"
    STEREO = "stereo"
    UNKNOWN = "unknown"

    @property
    def description(self) -> str:
        """One sentence for people."""
        return _DESCRIPTIONS[self]


_DESCRIPTIONS = {
    KittiLayout.OBJECT: "This is KITTI's object layout.",
    KittiLayout.DETECTIONS: "This is a detector's result folder.",
    KittiLayout.LABELS: "This is a label folder; name the folder above training/ to check all of "
    "it.",
    KittiLayout.RAW: "This is KITTI's raw layout.",
    KittiLayout.TRACKING: "This is KITTI's tracking layout.",
    KittiLayout.ODOMETRY: "This is KITTI's odometry layout.",
    KittiLayout.STEREO: "This is KITTI's stereo layout, of which the first image pairs (_10) and "
    "their disparities are read; `avsec disparity` scores disparities on them.",
    KittiLayout.UNKNOWN: "This is none of KITTI's layouts; expected is the folder that holds "
    "training/ with label_2/, calib/, image_2/ and so on, one with dates such as 2011_09_26/, "
    "or a folder with result files such as 000107.txt.",
}

_RAW_SIGNS = (
    "calib_cam_to_cam.txt",
    "*_extract",
    "velodyne_points",
    "image_[0-9][0-9]/data",
    "oxts/data",
    "tracklet_labels.xml",
)
"""Signs of a day or a drive that is not named as KITTI names them."""


def recognise(root: Path) -> KittiLayout:
    """The layout of a folder.

    Raises:
        DataError: There is no such folder.
    """
    if not is_folder(root):
        raise DataError("There is no such folder.", path=root, remedy="Check the path.")
    text_folder = text_file_folder(root)
    if text_folder is not None:
        return _labels_or_detections(text_folder)
    if find_raw(root)[0]:
        return KittiLayout.RAW
    if tracking_folders(root):
        return KittiLayout.TRACKING
    if odometry_folder(root) is not None:
        return KittiLayout.ODOMETRY
    if any(next(root.glob(sign), None) for sign in _RAW_SIGNS):
        return KittiLayout.RAW
    if stereo_folders(root):
        return KittiLayout.STEREO
    return KittiLayout.OBJECT if object_folders(root) else KittiLayout.UNKNOWN


def object_folders(root: Path) -> list[Path]:
    """The folders with object data: ``training`` and ``testing``, or the root itself."""
    halves = [root / half for half in ("training", "testing") if layout_folders(root / half)]
    return halves or ([root] if layout_folders(root) else [])


def tracking_folders(root: Path) -> list[Path]:
    """The folders with tracking data: both halves, one, or the root itself.

    A folder of labels alone, ``label_02``, stands for itself.
    """
    if Path(os.path.abspath(root)).name == LABELS:
        return [root]
    return [half for half in _halves(root) if sequence_names(half)]


def stereo_folders(root: Path) -> list[Path]:
    """The folders with stereo pairs: both halves, one, or the root itself."""
    return [half for half in _halves(root) if stereo_layout(half) is not None]


def _halves(root: Path) -> list[Path]:
    return [root / "training", root / "testing", root]


def text_file_folder(root: Path) -> Path | None:
    """The folder with files such as ``000107.txt``: the root or its ``data/``."""
    for folder in (root, root / "data"):
        if is_folder(folder) and frame_ids(folder, ".txt"):
            return folder
    return None


def _labels_or_detections(folder: Path) -> KittiLayout:
    """Decided by the columns of the first line in any file; results where all are empty."""
    for id in frame_ids(folder, ".txt"):
        try:
            words = read_text(folder / f"{id}.txt").split("\n", 1)[0].split()
        except DataError:
            continue
        if words:
            return KittiLayout.LABELS if len(words) == 15 else KittiLayout.DETECTIONS
    return KittiLayout.DETECTIONS
