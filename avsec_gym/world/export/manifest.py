"""``manifest.json`` of a data set: how it was made, by which version, and what every file holds."""

from __future__ import annotations

import functools
import hashlib
import json
import os
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

import avsec_gym
from avsec_gym.errors import DataError
from avsec_gym.kitti.atomic_write import write_bytes

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
    if not path.is_file():
        return None
    try:
        manifest = json.loads(path.read_bytes())
        sound = manifest["format"] == _FORMAT and {"complete", "settings", "files"} <= set(manifest)
    except (OSError, ValueError, KeyError, TypeError):
        sound = False
    if not sound:
        raise DataError("This is no manifest of a data set.", path=path, remedy=_REMEDY)
    return dict(manifest)


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
    """Files of a complete data set that are missing or not what the manifest says.

    Args:
        root: Of the data set.
        full: Read every file; else look at sizes.

    Returns:
        Their paths relative to the root; files that the manifest does not know are left alone.

    Raises:
        DataError: There is no manifest, or it says that the data set is not complete.
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


def _differs(path: Path, facts: Mapping[str, Any], full: bool) -> bool:
    try:
        if path.stat().st_size != facts["bytes"]:
            return True
        return full and _sha256(path) != facts["sha256"]
    except OSError:
        return True


def _sha256(path: Path) -> str:
    with open(path, "rb") as file:
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
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def _short(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
