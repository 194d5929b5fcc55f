"""Frames to fit an error model to: labels, result files, and who is who from frame to frame."""

from __future__ import annotations

from pathlib import Path
from typing import TypedDict

import numpy as np
from numpy.typing import NDArray

from avsec_gym.closed_loop.error_model.fit import DetectedFrame
from avsec_gym.errors import DataError
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.kitti.detections import DetectionFolder, above
from avsec_gym.storage.json_fields import check_fields
from avsec_gym.storage.json_files import read_json_object
from avsec_gym.storage.regular_files import is_there
from avsec_gym.world.export import actors_of, read_scene_file

_REMEDY = "Make the data set anew with `avsec world make`."
PERIOD = 0.1
"""Seconds between the frames of a drive of connected vehicles."""


class _Instant(TypedDict):
    """The place of an instant in its drive; the file has more."""

    drive: int
    frame: int


def stored_frames(
    kitti: str | Path,
    detections: str | Path,
    *,
    split: str | None = None,
    limit: int | None = None,
    score_threshold: float = 0.3,
) -> list[DetectedFrame]:
    """Frames with what is there and what a detector found.

    Args:
        kitti: Folder in KITTI's object layout.  Frames of one vehicle of a ``connected`` data set
            belong to drives, which all of its vehicles share; all others are drives of their own.
        detections: The detector's result folder.
        split: The frames of ``ImageSets/SPLIT.txt``; all labelled ones if None.
        limit: The number of frames that are taken, the first ones; None: all.
        score_threshold: The least score of a detection that is planned on.

    Raises:
        DataError: A folder or file is missing or broken, or there is no frame.
    """
    data = KittiObject(kitti)
    ids = data.ids(split, having=() if split else ("label_2",))[:limit]
    if not ids:
        raise DataError("There is no labelled frame.", path=kitti, remedy="Name another split.")
    found, _ = DetectionFolder(detections).read(ids)
    frames = []
    for id in ids:
        objects = data.labels(id, keep_dont_care=True)
        drive, time = _place_in_drive(data.folder, id)
        actors = _actors(data.folder / "scene" / f"{id}.json", len(objects))
        frames.append(
            DetectedFrame(
                objects, above(found[id], score_threshold), drive, time, actors, str(data.folder)
            )
        )
    return frames


def _place_in_drive(folder: Path, id: str) -> tuple[str, float]:
    """The drive of a frame, named with its data set, and the seconds since its start."""
    root = folder.parent.parent
    path = root / "objects" / f"{id}.json"
    if not is_there(path):
        return f"{folder} {id}", 0.0
    facts = read_json_object(path, remedy=_REMEDY)
    try:
        check_fields(_Instant, facts)
    except ValueError as error:
        raise DataError(f"The file is damaged: {error}.", path=path, remedy=_REMEDY) from error
    return f"{root} {facts['drive']}", PERIOD * facts["frame"]


def _actors(path: Path, count: int) -> NDArray[np.int64] | None:
    """The actor of each label line; None where they have no numbers."""
    if not is_there(path):
        return None
    numbers = actors_of(read_scene_file(path, remedy=_REMEDY))
    return None if numbers is None or len(numbers) != count else np.array(numbers, np.int64)
