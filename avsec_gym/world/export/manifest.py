"""``manifest.json`` of a data set: how it was made, by which version, and what every file holds."""

from __future__ import annotations

import functools
import hashlib
import json
import os
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path, PurePosixPath
from typing import Any

import avsec_gym
from avsec_gym.errors import DataError
from avsec_gym.storage.atomic_write import write_bytes
from avsec_gym.storage.json_files import read_json_object
from avsec_gym.storage.regular_files import (
    MAX_FILE_BYTES,
    is_file,
    is_there,
    open_regular,
    read_bytes,
)

MANIFEST = "manifest.json"
"""Its name."""

_PACKAGE = Path(avsec_gym.__file__).parent
_SOURCES = ("world", "kitti", "boxes.py", "frame.py", "geometry.py", "rig.py", "road_type.py")
_TOOLS = ("numpy", "numba", "embreex", "opencv-python-headless")
_FORMAT = 1
_REMEDY = "Name another folder with --out, or remove this one."


@functools.cache
def world_fingerprint() -> str:
    """Changes with any source that a data set depends on."""
    return _fingerprint(*_SOURCES)


def new_manifest(settings: Mapping[str, Any]) -> dict[str, Any]:
    """The manifest of a data set that is not complete."""
    return {
        "format": _FORMAT,
        "complete": False,
        "avsec_gym": avsec_gym.__version__,
        "fingerprint": world_fingerprint(),
        "textures": _fingerprint("world/textures"),
        "tools": {name: version(name) for name in _TOOLS},
        "settings": dict(settings),
        "frames": 0,
        "files": {},
    }


def read_manifest(root: str | Path) -> dict[str, Any] | None:
    """A data set's manifest; None where there is none.

    Raises:
        DataError: It cannot be read, or is none.
    """
    path = Path(root) / MANIFEST
    if not is_there(path):
        return None
    manifest = read_json_object(path, remedy=_REMEDY)
    if not _is_sound(manifest):
        raise DataError("This is no manifest of a data set.", path=path, remedy=_REMEDY)
    return manifest


def write_manifest(root: Path, manifest: Mapping[str, Any]) -> None:
    """Write it, over an earlier one."""
    text = json.dumps(manifest, indent=1, allow_nan=False) + "\n"
    write_bytes(root / MANIFEST, text.encode(), overwrite=True)


def check_same(root: Path, there: Mapping[str, Any], asked: Mapping[str, Any]) -> None:
    """Check that a data set may be continued.

    Raises:
        DataError: It was made with other settings, or by another version.
    """
    old, new = there["settings"], asked["settings"]
    for name in [*old, *(name for name in new if name not in old)]:
        if old.get(name) != new.get(name):
            raise DataError(
                f"The data set here has {name} {_short(old.get(name))}, asked is "
                f"{_short(new.get(name))}.",
                path=root,
                remedy=_REMEDY,
            )
    if there.get("fingerprint") != asked["fingerprint"]:
        raise DataError(
            f"The data set here was made by another version ({there.get('avsec_gym')}, sources "
            f"{there.get('fingerprint')}; this is {asked['avsec_gym']}, {asked['fingerprint']}).",
            path=root,
            remedy=_REMEDY,
        )


def list_files(root: Path) -> dict[str, dict[str, Any]]:
    """Size and SHA-256 of every file of a data set but the manifest, by its path."""
    paths = sorted(path for path in _all_files(root) if path != MANIFEST)
    return {
        path: {"bytes": (root / path).stat().st_size, "sha256": _sha256(root / path)}
        for path in paths
    }


def changed_files(root: str | Path, *, full: bool = False) -> list[str]:
    """Files of a complete data set that are missing or differ from the manifest.

    Args:
        root: Root of the data set.
        full: Whether every file is read instead of its size compared.

    Returns:
        Their paths relative to the root; files that the manifest does not know are left alone.

    Raises:
        DataError: There is no manifest, or the data set is not complete according to it.
    """
    root = Path(root)
    manifest = read_manifest(root)
    if manifest is None or not manifest["complete"]:
        raise DataError(
            "There is no manifest.json." if manifest is None else "The data set is not complete.",
            path=root,
            remedy="`avsec world make` with the same arguments completes a data set.",
        )
    return [name for name, facts in manifest["files"].items() if _differs(root / name, facts, full)]


def sweep(root: Path) -> None:
    """Remove the halves of files that a killed run left; the folder is ours."""
    for path in root.rglob(".*.tmp"):
        path.unlink(missing_ok=True)


def _is_sound(manifest: dict[str, Any]) -> bool:
    """Whether everything is there and of its type, and no name leads out of the data set."""
    files = manifest.get("files")
    return (
        manifest.get("format") == _FORMAT
        and isinstance(manifest.get("complete"), bool)
        and isinstance(manifest.get("settings"), dict)
        and isinstance(files, dict)
        and all(
            ".." not in (parts := PurePosixPath(name).parts)
            and parts[:1] not in ((), ("/",))
            and "\0" not in name
            and isinstance(facts, dict)
            and type(facts.get("bytes")) is int
            and isinstance(facts.get("sha256"), str)
            for name, facts in files.items()
        )
    )


def _differs(path: Path, facts: Mapping[str, Any], full: bool) -> bool:
    if not is_file(path) or path.stat().st_size != facts["bytes"]:
        return True
    return full and _sha256(path) != facts["sha256"]


def _sha256(path: Path) -> str:
    with open_regular(path, most=MAX_FILE_BYTES) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _all_files(root: Path) -> list[str]:
    """Relative paths with slashes; hidden files are not of the data set."""
    found = []
    for folder, names, files in os.walk(root):
        names[:] = [name for name in names if not name.startswith(".")]
        base = Path(folder).relative_to(root)
        found += [(base / file).as_posix() for file in files if not file.startswith(".")]
    return found


def _fingerprint(*names: str) -> str:
    digest = hashlib.sha256()
    for name in names:
        place = _PACKAGE / name
        for path in sorted(place.rglob("*.py")) if place.is_dir() else [place]:
            digest.update(path.relative_to(_PACKAGE).as_posix().encode())
            digest.update(read_bytes(path, most=MAX_FILE_BYTES))
    return digest.hexdigest()[:16]


def _short(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
