"""Whether a file is still the one that samples were prepared from."""

from __future__ import annotations

import os
from pathlib import Path


def file_version(path: Path) -> tuple[str, tuple[int, int] | None]:
    """Where a file is, its size and when it was written (ns); no more than where, if it is not."""
    status = path.stat() if path.is_file() else None
    return os.fspath(path.resolve()), status and (status.st_size, status.st_mtime_ns)
