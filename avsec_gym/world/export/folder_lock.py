"""One process at a time in a folder; the lock goes when its process does."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from avsec_gym.errors import DataError


@contextmanager
def folder_lock(folder: Path, *, wait: bool = False) -> Iterator[None]:
    """Hold a folder; nothing is written into it.

    Where the system cannot lock folders (Windows, some network drives), nothing is held.

    Args:
        folder: Is there.
        wait: For another process that holds it.

    Raises:
        DataError: Another process holds it and `wait` is false.
    """
    if sys.platform == "win32":
        yield
        return
    import fcntl

    handle = os.open(folder, os.O_RDONLY)
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
        except BlockingIOError:
            raise DataError(
                "Another process is writing here.",
                path=folder,
                remedy="Wait for it, or name another folder.",
            ) from None
        except OSError:
            pass
        yield
    finally:
        os.close(handle)
