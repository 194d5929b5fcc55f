"""The motion planner M: motion primitives and best-first search (thesis, section 5.3.3).

Its kernels are compiled by numba, which keeps them beside the package or in the user's cache
folder; where neither can be written, a temporary folder serves for this process.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

from platformdirs import user_cache_dir


def _provide_cache_folder() -> None:
    import numba

    settings: Any = numba.config
    if settings.CACHE_DIR:
        return
    beside = Path(__file__).parent / "__pycache__"
    if not any(map(_is_writable, (beside, Path(user_cache_dir("numba"))))):
        settings.CACHE_DIR = tempfile.mkdtemp(prefix="avsec-gym-")


def _is_writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


_provide_cache_folder()
