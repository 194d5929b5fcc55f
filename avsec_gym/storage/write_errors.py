"""Errors of a disk while a file is written, which by themselves name none."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from avsec_gym.errors import DataError


@contextmanager
def naming(path: Path, *others: type[Exception]) -> Iterator[None]:
    """Errors of the system become errors of the file that is written.

    Args:
        path: The file, or the folder of files that a library writes.
        others: Further errors by which a library reports those of the system.

    Raises:
        DataError: It cannot be written, as where the disk is full.
    """
    kinds: tuple[type[Exception], ...] = (OSError, *others)
    try:
        yield
    except kinds as error:
        raise DataError(
            f"The file cannot be written ({getattr(error, 'strerror', None) or error}).",
            path=path,
            remedy="Check the folder's permissions and the free space.",
        ) from error
