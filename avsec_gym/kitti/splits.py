"""Which frames belong to a split, and where in KITTI raw an object frame was recorded."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from avsec_gym.errors import DataError
from avsec_gym.kitti.label_folders import is_id
from avsec_gym.storage.text_files import read_text

_DRIVE = re.compile(r"([0-9]{4}_[0-9]{2}_[0-9]{2})_drive_([0-9]{4})_(?:sync|extract)")


@dataclass(frozen=True)
class RawOrigin:
    """The place of an object frame in the raw recordings."""

    date: str
    """Such as ``2011_09_26``."""
    drive: str
    """Such as ``0005``."""
    frame: int
    """Counted from 0."""

    @property
    def folder(self) -> str:
        """The drive's folder in the raw layout, relative to its root."""
        return f"{self.date}/{self.date}_drive_{self.drive}_sync"


def read_split(path: str | Path) -> list[str]:
    """Ids of a split file such as ``ImageSets/val.txt``, in its order.

    Raises:
        DataError: A line is not six digits, or an id stands twice.
    """
    lines = read_text(path).rstrip().split("\n")
    seen: dict[str, int] = {}
    for number, line in enumerate(lines if lines != [""] else [], start=1):
        id = line.strip(" \t\r")
        if not is_id(id):
            raise DataError(
                f"A split names one frame of six digits in each line, this one holds {id[:40]!r}.",
                path=path,
                line=number,
                remedy="Correct the line, such as 000107.",
            )
        if id in seen:
            raise DataError(
                f"Frame {id} stands in line {seen[id]} already.",
                path=path,
                line=number,
                remedy="Remove one of the two lines: a frame counts once.",
            )
        seen[id] = number
    return list(seen)


def read_raw_mapping(folder: str | Path) -> dict[str, RawOrigin]:
    """Where each training frame comes from, by its id.

    The devkit's ``train_rand.txt`` gives, for frame i, a line number (from 1) of
    ``train_mapping.txt``.

    Args:
        folder: The devkit's ``mapping`` folder.

    Raises:
        DataError: A file is missing or malformed, or the two do not fit together.
    """
    rand, mapping = Path(folder) / "train_rand.txt", Path(folder) / "train_mapping.txt"
    origins = [
        _origin(line, mapping, number)
        for number, line in enumerate(read_text(mapping).rstrip().split("\n"), start=1)
    ]
    words = read_text(rand).rstrip().rstrip(",").replace("\n", ",").split(",")
    result: dict[str, RawOrigin] = {}
    used: set[int] = set()
    for i, word in enumerate(words):
        word = word.strip()
        index = int(word) if word.isascii() and word.isdecimal() and len(word) < 9 else 0
        if not 1 <= index <= len(origins) or index in used:
            raise DataError(
                f"Entry {i + 1} is {word[:40]!r}; expected a permutation of 1 to {len(origins)}.",
                path=rand,
                line=1,
                remedy="Take both files from the same object devkit.",
            )
        used.add(index)
        result[f"{i:06d}"] = origins[index - 1]
    return result


def _origin(line: str, path: Path, number: int) -> RawOrigin:
    words = line.split()
    drive = _DRIVE.fullmatch(words[1]) if len(words) == 3 else None
    if drive is None or drive[1] != words[0] or not re.fullmatch(r"[0-9]{1,10}", words[2]):
        raise DataError(
            f"A line holds date, drive and frame, this one {line[:80]!r}.",
            path=path,
            line=number,
            remedy="Take the file from the object devkit.",
        )
    return RawOrigin(date=words[0], drive=drive[2], frame=int(words[2]))
