"""Folders to write into, made where they lack."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from avsec_gym.errors import DataError
from avsec_gym.storage.regular_files import is_folder, is_there


def named(path: str | Path) -> Path:
    """A file's path, which ends in the file's name.

    Raises:
        DataError: It is empty, or a folder's, such as ``.`` and ``/``.
    """
    if not Path(path).name:
        _check_not_empty(path)
        raise DataError(
            "This is a folder, where a file is to be written.",
            path=path,
            remedy="Name another place.",
        )
    return Path(path)


def make_folder(folder: str | Path) -> None:
    """Make a folder and those above it, where they lack.

    Raises:
        DataError: The path is empty, a file stands in its place or above it, or the system does not
            let us make it.
    """
    _check_not_empty(folder)
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:  # ValueError: a NUL in the name.
        there = next((each for each in (folder, *folder.parents) if is_there(each)), folder)
        if is_there(there) and not is_folder(there):
            raise DataError(
                "This is a file, where a folder is needed.",
                path=there,
                remedy="Name another place, or move the file away.",
            ) from error
        reason = error.strerror if isinstance(error, OSError) else "no folder can have this name"
        raise DataError(
            f"The folder cannot be made ({reason}).",
            path=folder,
            remedy="Check the path, its permissions and the free space.",
        ) from error


@contextmanager
def made_folder(folder: str | Path) -> Iterator[Path]:
    """A folder to write into, made where it lacks.

    Where that ends in an error before anything is in it, what was made goes again: a slip in the
    arguments leaves no empty folders behind.

    Raises:
        DataError: As of `make_folder`.
    """
    _check_not_empty(folder)
    folder = Path(folder)
    lacking = [each for each in (folder, *folder.parents) if not os.path.lexists(each)]
    try:
        make_folder(folder)
        yield folder
    except BaseException:
        for each in lacking:
            with suppress(OSError):  # One that holds something stays, and so do those above it.
                each.rmdir()
        raise


def _check_not_empty(path: str | Path) -> None:
    """Raise DataError where a path is empty: to `Path`, that is the folder that one is in."""
    if not os.fspath(path):
        raise DataError("The path is empty.", remedy="Name a place, such as . for this folder.")
