"""What is there, what is missing and what is broken in a folder of KITTI data."""

from __future__ import annotations

from pathlib import Path

from avsec_gym.kitti.archives import archives_apart
from avsec_gym.kitti.check_object import check_object, check_text_folder
from avsec_gym.kitti.check_raw import check_raw
from avsec_gym.kitti.check_sequences import check_odometry, check_tracking
from avsec_gym.kitti.check_stereo import check_stereo
from avsec_gym.kitti.layouts import KittiLayout, object_folders, recognise, text_file_folder
from avsec_gym.kitti.other_data import other_data
from avsec_gym.kitti.report import DataReport, Survey
from avsec_gym.progress import Progress
from avsec_gym.storage.regular_files import is_folder

_CHECKED = (
    KittiLayout.OBJECT,
    KittiLayout.RAW,
    KittiLayout.TRACKING,
    KittiLayout.ODOMETRY,
    KittiLayout.STEREO,
)


def check_data(
    root: str | Path, *, deep: bool = False, on_progress: Progress | None = None
) -> DataReport:
    """Look at every file of a data set in one of KITTI's layouts, or of a result folder.

    Goes on after a broken file.  Parts that are missing are reported and no fault.

    Args:
        root: Folder to check: of the object layout, the folder that holds ``training/``, or one
            such as ``training``; of the raw layout, the folder of the dates, of a date, or of a
            drive; of the tracking and stereo layouts, the folder that holds ``training/``; of the
            odometry layout, the one that holds ``sequences/``; or a folder of labels or results.
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
        check_tracking(survey, deep=deep)
    elif survey.layout is KittiLayout.ODOMETRY:
        check_odometry(survey, deep=deep)
    elif survey.layout is KittiLayout.STEREO:
        check_stereo(survey, deep=deep)
    elif text_folder is not None:
        check_text_folder(survey, text_folder)
    elif survey.layout is KittiLayout.UNKNOWN:
        _look_around(survey)
    apart = archives_apart(root)
    if apart is not None:
        survey.notes.append(apart.advice)
    return survey.report()


def _look_around(survey: Survey) -> None:
    """Find out what an unknown folder is instead, or which of its subfolders are KITTI's."""
    other = other_data(survey.root)
    if other is not None:
        survey.notes.append(other.advice)
        return
    for child in sorted(path for path in survey.root.iterdir() if is_folder(path)):
        layout, other = recognise(child), other_data(child)
        if layout in _CHECKED:
            survey.notes.append(f"Its subfolder {child.name}/ has the {layout} layout: name that.")
        elif other is not None and layout is KittiLayout.UNKNOWN:
            survey.notes.append(f"In its subfolder {child.name}/: {other.advice}")
