"""Kernels: functions that numba compiles, and keeps on disk for the sources that they were made of.

numba looks at the file that defines a kernel, and at no other: after an update, it runs code that
was compiled with an earlier version of what the kernel calls, or ends in an error over a type that
has another name now.  Here, each kernel's folder is named by a digest of its file and of all files
of the package that this one imports, and so on: other sources, another folder.
"""

from __future__ import annotations

import re
import shutil
import tempfile
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from hashlib import blake2b
from pathlib import Path
from typing import Any

import numba
from platformdirs import user_cache_dir

_PACKAGE = Path(__file__).parent
_IMPORT = re.compile(rb"^[ \t]*from ([\w.]+) import (\([^)]*\)|[^\n]*)", re.MULTILINE)
_KEPT = 3
"""Folders of earlier sources of a file: who goes back and forth between two need not wait."""


def kernel(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Compile a function when it is called first, and keep it on disk.

    Args:
        options: Options of `numba.njit`, such as ``nogil=True``.

    Returns:
        The decorator.
    """

    def decorate(function: Callable[..., Any]) -> Any:
        settings: Any = numba.config
        asked = settings.CACHE_DIR
        # numba looks for a place as soon as a function is decorated.
        settings.CACHE_DIR = str(_folder(Path(function.__code__.co_filename), asked))
        try:
            return numba.njit(cache=True, **options)(function)
        finally:
            settings.CACHE_DIR = asked

    return decorate


def sources_of(path: Path) -> frozenset[Path]:
    """A file of the package and all that it imports of it, directly or by way of others."""
    found, waiting = {path}, [path]
    while waiting:
        new = _imported(waiting.pop()) - found
        found |= new
        waiting += new
    return frozenset(found)


@cache
def _folder(path: Path, asked: str) -> Path:
    """The folder for the kernels of a file: where the user asked for it, else beside the file.

    Else it is in the user's folder for caches, else one that this process has for itself.
    """
    inside = path.relative_to(_PACKAGE)
    name = ".".join(inside.with_suffix("").parts)
    digest = blake2b(digest_size=8)
    for source in sorted(sources_of(path)):
        digest.update(f"{source.relative_to(_PACKAGE)} {_content(source)[0]} ".encode())
    user = Path(user_cache_dir("avsec-gym"))
    for root in [Path(asked)] if asked else [path.parent / "__pycache__", user]:
        folder = root / "kernels" / f"{name}-{digest.hexdigest()}"
        with suppress(OSError):
            if not folder.exists():
                folder.mkdir(parents=True)
                _clean(folder.parent, name)
            with tempfile.TemporaryFile(dir=folder):
                return folder
    return _own_folder()


def _clean(root: Path, name: str) -> None:
    """Keep the newest folders of a file's kernels; other processes may clean at the same time."""
    folders = []
    for folder in root.glob(f"{name}-*"):
        with suppress(OSError):
            folders.append((folder.stat().st_mtime, folder))
    for _, folder in sorted(folders)[: -_KEPT - 1]:
        shutil.rmtree(folder, ignore_errors=True)


@cache
def _own_folder() -> Path:
    return Path(tempfile.mkdtemp(prefix="avsec-gym-"))


@cache
def _content(path: Path) -> tuple[str, bytes]:
    """A digest of a file, and the file."""
    content = path.read_bytes()
    return blake2b(content, digest_size=16).hexdigest(), content


def _imported(path: Path) -> set[Path]:
    """The files of the package that a file imports from, or imports."""
    found = set()
    for module, names in _IMPORT.findall(_content(path)[1]):
        first, *rest = module.decode().split(".")
        if first != _PACKAGE.name:
            continue
        place = _PACKAGE.joinpath(*rest)
        inner = [place / name for name in re.findall(r"\w+", names.decode())]
        for each in (place, *inner):
            found |= {each.with_suffix(".py"), each / "__init__.py"}
    return {each for each in found if each.is_file()}
