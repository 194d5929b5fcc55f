"""Small text files: read with suspicion, written in one piece."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from avsec_gym.errors import DataError
from avsec_gym.kitti.atomic_write import write_bytes

MAX_BYTES = 16 * 2**20
"""KITTI's text files have a few kilobytes; what is larger than this is something else."""


def read_text(path: str | Path, *, most: int = MAX_BYTES) -> str:
    """The text of a small UTF-8 file.

    Args:
        path: The file.
        most: Bytes beyond which it is refused.

    Raises:
        DataError: No such file, not a regular file, not readable, too large, or not UTF-8.
    """
    try:
        status = os.stat(path)
        if not stat.S_ISREG(status.st_mode):
            raise DataError("This is not a file.", path=path, remedy="Name a text file.")
        if status.st_size > most:
            raise DataError(
                f"A text file of {status.st_size} bytes is too large to be true.",
                path=path,
                remedy=f"Such files have a few kilobytes; at most {most} are read.",
            )
        with open(path, "rb", buffering=0) as file:
            content = file.read()
    except FileNotFoundError as error:
        raise DataError(
            "There is no such file.", path=path, remedy="Check the path and the download."
        ) from error
    except (OSError, ValueError) as error:
        raise DataError(
            f"The file cannot be read ({error}).", path=path, remedy="Check path and permissions."
        ) from error
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError as error:
        raise DataError(
            f"The byte 0x{content[error.start]:02x} is not UTF-8 text.",
            path=path,
            line=content.count(b"\n", 0, error.start) + 1,
            remedy="The file may be binary, compressed or damaged; fetch it again.",
        ) from error


def write_text(path: str | Path, text: str, *, overwrite: bool = False) -> None:
    """Write a UTF-8 file whole or not at all; see `write_bytes`, also for errors."""
    write_bytes(path, text.encode("utf-8"), overwrite=overwrite)
