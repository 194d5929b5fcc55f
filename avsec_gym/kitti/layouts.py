"""Which of KITTI's layouts a folder has, recognised by the names in it."""

from __future__ import annotations

import os
from enum import StrEnum
from pathlib import Path

from avsec_gym.errors import DataError
from avsec_gym.kitti.dataset import layout_folders
from avsec_gym.kitti.label_folders import frame_ids
from avsec_gym.kitti.raw import find_raw
from avsec_gym.storage.regular_files import is_folder
from avsec_gym.storage.text_files import read_text

TRACKING_LABELS = "label_02"
"""The folder of the tracking benchmark's labels."""


class KittiLayout(StrEnum):
    """What a folder was recognised as."""

    OBJECT = "object"
    DETECTIONS = "detections"
    LABELS = "labels"
    RAW = "raw"
    TRACKING = "tracking"
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
    KittiLayout.TRACKING: "This is KITTI's tracking layout, of which labels and calibration are "
    "read.",
    KittiLayout.STEREO: "This looks like KITTI stereo or flow, which this check does not read.",
    KittiLayout.UNKNOWN: "This is none of KITTI's layouts; expected is the folder that holds "
    "training/ with label_2/, calib/, image_2/ and so on, one with dates such as 2011_09_26/, "
    "or a folder with result files such as 000107.txt.",
}

_SIGNS = {
    KittiLayout.RAW: (
        "calib_cam_to_cam.txt",
        "*_extract",
        "velodyne_points",
        "image_[0-9][0-9]/data",
        "oxts/data",
        "tracklet_labels.xml",
    ),
    KittiLayout.TRACKING: ("image_02", "training/image_02"),
    KittiLayout.STEREO: ("disp_*", "colored_0", "training/disp_*", "training/colored_0"),
}


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
    for layout, signs in _SIGNS.items():
        if any(next(root.glob(sign), None) for sign in signs):
            return layout
    return KittiLayout.OBJECT if object_folders(root) else KittiLayout.UNKNOWN


def object_folders(root: Path) -> list[Path]:
    """The folders with object data: ``training`` and ``testing``, or the root itself."""
    halves = [root / half for half in ("training", "testing") if layout_folders(root / half)]
    return halves or ([root] if layout_folders(root) else [])


def tracking_folders(root: Path) -> list[Path]:
    """The folders with tracking labels: of both halves, of one, or the root itself."""
    if Path(os.path.abspath(root)).name == TRACKING_LABELS:
        return [root]
    halves = (root / half / TRACKING_LABELS for half in ("training", "testing", "."))
    return [folder for folder in halves if is_folder(folder)]


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
