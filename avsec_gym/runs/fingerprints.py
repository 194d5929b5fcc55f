"""What distinguishes versions of files, of this package and of its libraries."""

from __future__ import annotations

import hashlib
import os
import platform
from importlib import metadata
from pathlib import Path
from typing import TypedDict

import avsec_gym
from avsec_gym import registry
from avsec_gym.errors import DataError
from avsec_gym.runs import catalogue
from avsec_gym.storage.regular_files import (
    MAX_FILE_BYTES,
    check_regular,
    is_file,
    is_folder,
    open_regular,
    read_bytes,
)

_LIBRARIES = (
    "commonroad-io",
    "embreex",
    "gymnasium",
    "numba",
    "numpy",
    "opencv-python-headless",
    "shapely",
    "torch",
)
_READ_WHOLE = {".txt", ".csv", ".json", ".xml", ".yaml"}


def fingerprint(path: Path) -> str:
    """Changes with the content of a file or folder.

    Of a data set whose ``manifest.json`` states what each file holds, the manifest is read.
    Of other folders, labels and other text files are read, and of images and scans the names and
    sizes taken: reading them would take minutes.

    Returns:
        SHA-256 of a file's bytes or of what is listed above, as hexadecimal digits.

    Raises:
        DataError: It is not there, or cannot be read.
    """
    if is_file(path / "manifest.json"):
        path = path / "manifest.json"
    if is_file(path):
        return _sha256(path)
    if is_folder(path):
        return _of_folder(path)
    raise DataError("It is not there.", path=path, remedy="Check the path.")


def package_fingerprint() -> str:
    """Sixteen digits that change with any source of this package."""
    root = Path(avsec_gym.__file__).parent
    digest = hashlib.sha256()
    for path in sorted(root.rglob("*.py")):
        digest.update(path.relative_to(root).as_posix().encode())
        digest.update(read_bytes(path, most=MAX_FILE_BYTES))
    return digest.hexdigest()[:16]


class Environment(TypedDict):
    """What the results of a sitting may hang on, beside the run's own arguments."""

    versions: dict[str, str]
    """Versions of this package, of libraries and of plug-ins."""
    sources: str
    """See `package_fingerprint`."""
    python: str
    platform: str
    processors: int | None


def environment() -> Environment:
    """Versions and machine; nothing is imported for it."""
    versions = {"avsec-gym": avsec_gym.__version__}
    for name in _LIBRARIES:
        try:
            versions[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return {
        "versions": versions | _plug_ins(),
        "sources": package_fingerprint(),
        "python": platform.python_version(),
        "platform": platform.platform(),
        "processors": os.cpu_count(),
    }


def _plug_ins() -> dict[str, str]:
    """Versions of the installed packages that add parts or experiments, sorted by name."""
    points = [
        point
        for group in (registry.GROUP, catalogue.GROUP)
        for point in metadata.entry_points(group=group)
    ]
    packages = {point.dist.name: point.dist.version for point in points if point.dist}
    return dict(sorted(packages.items()))


def _of_folder(root: Path) -> str:
    digest = hashlib.sha256()
    for path in sorted(_files(root)):
        digest.update(path.relative_to(root).as_posix().encode())
        said = (
            _sha256(path)
            if path.suffix in _READ_WHOLE
            else str(check_regular(path, most=MAX_FILE_BYTES))
        )
        digest.update(f" {said}\n".encode())
    return digest.hexdigest()


def _files(root: Path) -> list[Path]:
    """All but hidden ones; links are followed, as readers follow them."""
    found = []
    for folder, names, files in os.walk(root, followlinks=True):
        names[:] = [name for name in names if not name.startswith(".")]
        found += [Path(folder) / file for file in files if not file.startswith(".")]
    return found


def _sha256(path: Path) -> str:
    with open_regular(path, most=MAX_FILE_BYTES) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
