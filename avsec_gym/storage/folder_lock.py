"""One process at a time in a folder; the lock goes when its process does."""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from avsec_gym.errors import DataError
from avsec_gym.storage.folders import made_folder

_LOG = logging.getLogger(__name__)
_HELD: set[int] = set()
"""Handles of the locks that this process holds, or waits for."""


@contextmanager
def folder_lock(folder: Path, *, wait: bool = False, what: str = "a folder") -> Iterator[None]:
    """Hold a folder; nothing is written into it.

    Where the system cannot lock folders (Windows, some network drives), nothing is held.

    Args:
        folder: The folder, which is there.
        wait: Whether to wait for another process that holds it; the wait is logged.
        what: Purpose for which this process needs it, such as ``the default suite mixed``.

    Raises:
        DataError: Another process holds it and `wait` is false.
    """
    if sys.platform == "win32":
        yield
        return
    import fcntl

    handle = os.open(folder, os.O_RDONLY)
    _HELD.add(handle)
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if not wait:
                raise DataError(
                    "Another process is writing here.",
                    path=folder,
                    remedy="Wait for it, or name another folder.",
                ) from None
            _LOG.warning("waiting for %s: another process is at work in %s", what, folder)
            fcntl.flock(handle, fcntl.LOCK_EX)
        except OSError:
            pass
        yield
    finally:
        if handle in _HELD:  # Else this is a forked process, which has let go of it.
            _HELD.discard(handle)
            with suppress(OSError):
                fcntl.flock(handle, fcntl.LOCK_UN)
            os.close(handle)


@contextmanager
def locked_folder(folder: str | Path) -> Iterator[Path]:
    """A folder that this process alone writes, made where it lacks.

    It goes again where nothing comes of it, see `made_folder`.

    Raises:
        DataError: Another process is writing there, or it cannot be made.
    """
    with made_folder(folder) as made, folder_lock(made):
        yield made


def _let_go() -> None:
    """A forked process has its parent's handles: if that is killed, it would keep the lock.

    No process could have it then, not even this one: it would wait for itself.
    """
    for handle in _HELD:
        os.close(handle)
    _HELD.clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_let_go)
