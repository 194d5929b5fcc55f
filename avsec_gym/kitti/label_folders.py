"""Folders that hold one text file for each frame, such as ``label_2``."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from pathlib import Path

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.kitti.labels import read_labels

_ID = re.compile(r"[0-9]{6}")


def read_label_folder(
    folder: str | Path, ids: Iterable[str] | None = None, *, keep_dont_care: bool = False
) -> dict[str, Boxes3D]:
    """Ground truth of many frames.

    Args:
        folder: A ``label_2`` folder.
        ids: Frames such as ``000107``; all that are there if None.
        keep_dont_care: Whether DontCare lines are kept, as for `read_labels`.

    Returns:
        The boxes by id, in the order asked for; sorted where none is.

    Raises:
        DataError: A label is missing or broken; the first one is named.
    """
    folder = Path(folder)
    chosen = frame_ids(folder, ".txt") if ids is None else [check_id(id) for id in ids]
    base = str(folder)
    return {
        id: read_labels(f"{base}{os.sep}{id}.txt", keep_dont_care=keep_dont_care) for id in chosen
    }


def frame_ids(folder: str | Path, suffix: str) -> list[str]:
    """Sorted ids of the files in a folder that are named by an id and the suffix.

    Raises:
        DataError: There is no such folder.
    """
    try:
        with os.scandir(folder) as entries:
            names = [entry.name for entry in entries]
    except (OSError, ValueError) as error:  # ValueError: a NUL in the name.
        raise DataError(
            "There is no such folder, or it cannot be read.",
            path=folder,
            remedy="Check the path and the download.",
        ) from error
    return sorted(
        name[:6] for name in names if name.endswith(suffix) and is_id(name[: -len(suffix)])
    )


def other_names(folder: str | Path, suffix: str) -> list[str]:
    """Sorted names of the files with the suffix that are not named by an id."""
    with os.scandir(folder) as entries:
        names = [entry.name for entry in entries]
    return sorted(
        name for name in names if name.endswith(suffix) and not is_id(name[: -len(suffix)])
    )


def is_id(id: str) -> bool:
    """Whether a text is an object frame's id: six digits."""
    return _ID.fullmatch(id) is not None


def check_id(id: str) -> str:
    """The id itself.

    Raises:
        ConfigurationError: It is not six digits.
    """
    if not isinstance(id, str) or not is_id(id):
        raise ConfigurationError(f"a frame's id has six digits, such as '000107', got {id!r}")
    return id
