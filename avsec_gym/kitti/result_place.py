"""Where a detector's result files are below the folder that a user names.

OpenPCDet writes them into ``eval/epoch_80/val/default/final_result/data`` of its output.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from avsec_gym.errors import DataError
from avsec_gym.kitti.label_folders import frame_ids

_DEEPEST = 10
"""Floors below the named folder; OpenPCDet's lie nine below its output."""
_MOST_FOLDERS = 2000
"""Most folders that are looked into: of a home or a data set, no more."""
_NAMED = 5
"""So many candidates are named in an error."""


def result_folder(given: Path) -> Path:
    """The folder that holds result files such as ``000107.txt``.

    Args:
        given: The result folder, or one above it.  Its own files win, then those of its ``data/``.

    Raises:
        DataError: There is no such folder, no result file in it or below, or several folders
            below hold some.
    """
    if frame_ids(given, ".txt"):
        return given
    if _has_results(given / "data"):  # As KITTI's own server has them.
        return given / "data"
    found = []
    for looked_at, folder in enumerate(_below(given)):
        if looked_at == _MOST_FOLDERS:
            raise DataError(
                f"The folder holds no result files, and more than {_MOST_FOLDERS} folders are"
                " below.",
                path=given,
                remedy="Name the folder that holds files such as 000107.txt.",
            )
        if _has_results(folder):
            found.append(folder)
    if len(found) > 1:
        names = ", ".join(str(place.relative_to(given)) for place in sorted(found)[:_NAMED])
        more = f" and {len(found) - _NAMED} more" if len(found) > _NAMED else ""
        raise DataError(
            f"{len(found)} folders below hold result files: {names}{more}.",
            path=given,
            remedy="Name one of them.",
        )
    if not found:
        raise DataError(
            "The folder holds no result files.",
            path=given,
            remedy="Expected are files such as 000107.txt, here or in one folder below, as"
            " OpenPCDet's final_result/data.",
        )
    return found[0]


def _below(root: Path) -> Iterator[Path]:
    """Folders below, those of a floor before those of the next; links are not followed."""
    floor = [root]
    for _ in range(_DEEPEST):
        floor = [folder for above in floor for folder in _folders(above)]
        yield from floor


def _folders(folder: Path) -> list[Path]:
    try:
        with os.scandir(folder) as entries:
            return sorted(
                Path(entry.path)
                for entry in entries
                if entry.is_dir(follow_symlinks=False) and not entry.name.startswith(".")
            )
    except OSError:
        return []  # What may not be looked into holds nothing that may be read.


def _has_results(folder: Path) -> bool:
    try:
        return bool(frame_ids(folder, ".txt"))
    except DataError:
        return False
