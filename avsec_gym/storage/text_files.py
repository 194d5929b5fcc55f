"""Small text files: read with suspicion, written in one piece."""

from __future__ import annotations

from pathlib import Path

from avsec_gym.storage.atomic_write import write_bytes
from avsec_gym.storage.regular_files import read_text

__all__ = ["read_text", "write_text"]


def write_text(path: str | Path, text: str, *, overwrite: bool = False) -> None:
    """Write a UTF-8 file whole or not at all; see `write_bytes`, also for errors.

    A path that the text mentions may be no text to Python: under a POSIX locale, it keeps the bytes
    of such names as lone surrogates.  The bytes themselves are written, escapes where they are no
    UTF-8.
    """
    try:
        content = text.encode("utf-8", "surrogateescape")
        content.decode()
    except UnicodeError:
        content = text.encode("utf-8", "backslashreplace")
    write_bytes(path, content, overwrite=overwrite)
