"""What is there, what is missing and what is broken in a folder of KITTI data."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

from avsec_gym.kitti.check_object import check_object, check_text_folder, look_at_calibration
from avsec_gym.kitti.check_raw import check_raw
from avsec_gym.kitti.layouts import (
    KittiLayout,
    object_folders,
    recognise,
    text_file_folder,
    tracking_folders,
)
from avsec_gym.kitti.report import DataReport, Files, Look, Progress, Sizes, Survey
from avsec_gym.kitti.tracking import read_tracking_labels
from avsec_gym.storage.regular_files import is_folder

_CHECKED = (KittiLayout.OBJECT, KittiLayout.RAW, KittiLayout.TRACKING)
_SEQUENCE = re.compile(r"[0-9]{4}\.txt")


def check_data(
    root: str | Path, *, deep: bool = False, on_progress: Progress | None = None
) -> DataReport:
    """Look at every file of a data set in one of KITTI's layouts, or of a result folder.

    Goes on after a broken file.  Parts that are missing are reported and no fault.

    Args:
        root: Folder to check: of the object layout, the folder that holds ``training/``, or one
            such as ``training``; of the raw layout, the folder of the dates, of a date, or of a
            drive; of the tracking layout, the folder that holds ``training/label_02``; or a folder
            of labels or results.
        deep: Whether images and scans are read whole; else headers, ends and sizes are.
        on_progress: Function that is called after each file.

    Raises:
        DataError: There is no such folder.
    """
    root = Path(root)
    survey = Survey(root, recognise(root), on_progress)
    text_folder = text_file_folder(root)
    if survey.layout is KittiLayout.OBJECT:
        check_object(survey, deep=deep)
    elif survey.layout is KittiLayout.RAW:
        check_raw(survey, deep=deep)
        survey.notes += [
            f"{survey.name(folder)}/ has the object layout: name that to check it, too."
            for folder in object_folders(root)
        ]
    elif survey.layout is KittiLayout.TRACKING:
        _check_tracking(survey)
    elif text_folder is not None:
        check_text_folder(survey, text_folder)
    elif survey.layout is KittiLayout.UNKNOWN:
        layouts = {child: recognise(child) for child in sorted(root.iterdir()) if is_folder(child)}
        survey.notes += [
            f"Its subfolder {child.name}/ has the {layout} layout: name that."
            for child, layout in layouts.items()
            if layout in _CHECKED
        ]
    return survey.report()


def _check_tracking(survey: Survey) -> None:
    """Look at labels and calibration of the tracking benchmark."""
    looks: dict[Path, Look] = {}
    for labels in tracking_folders(survey.root):
        looks[labels] = _look_at_tracking
        calibration = labels.parent / "calib"
        if labels != survey.root and is_folder(calibration):
            looks[calibration] = look_at_calibration
    groups = []
    for folder, look in looks.items():
        every = sorted(folder.iterdir())
        sequences = [path for path in every if _SEQUENCE.fullmatch(path.name)]
        survey.note_others(folder, [path for path in every if path not in sequences])
        groups.append(Files(folder, sequences, look))
    survey.look_at(groups)


def _look_at_tracking(path: Path, objects: Counter[str], _: Sizes) -> None:
    for frame in read_tracking_labels(path, keep_dont_care=True).values():
        objects.update(frame.boxes.category.tolist())
