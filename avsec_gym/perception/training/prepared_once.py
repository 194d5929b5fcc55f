"""What is computed once from files and kept: as long as they are the same, and only if whole."""

from __future__ import annotations

import hashlib
import os
import shutil
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from avsec_gym.storage.folders import made_folder, make_folder


def fingerprint(what: object, files: Iterable[Path]) -> str:
    """Changes with the `repr` of what is made of files, and with where, how large, how old each is.

    Returns:
        64 hexadecimal digits.
    """
    digest = hashlib.sha256(repr(what).encode())
    for file in files:
        status = file.stat() if file.is_file() else None
        version = status and (status.st_size, status.st_mtime_ns)
        digest.update(repr((os.fspath(file.resolve()), version)).encode())
    return digest.hexdigest()


@contextmanager
def whole_folder(folder: Path) -> Iterator[Path]:
    """A folder to write into, which takes this one's place if all goes well; else nothing stays."""
    partial = folder.with_name(f".{folder.name}.{os.getpid()}.part")
    with made_folder(folder.parent):
        shutil.rmtree(partial, ignore_errors=True)
        try:
            make_folder(partial)
            yield partial
            shutil.rmtree(folder, ignore_errors=True)
            partial.rename(folder)
        finally:
            shutil.rmtree(partial, ignore_errors=True)
