"""The files that JSON names, such as the thresholds of a validator: they decide results, too."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from avsec_gym.storage.regular_files import is_file, is_folder

_FOLDERS = ("source", "root", "kitti")
"""Arguments that may name a folder; elsewhere a folder of that name is a coincidence."""


def named_files(what: Any) -> dict[str, str]:
    """Fingerprints of the files and folders that arguments name, by their names.

    Args:
        what: JSON-able: a name, arguments, or lists of these.

    Raises:
        DataError: One of them cannot be read.
    """
    from avsec_gym.runs.fingerprints import fingerprint

    if isinstance(what, str):
        return {what: fingerprint(Path(what))} if is_file(what) else {}
    if isinstance(what, (list, tuple)):
        return {name: found for each in what for name, found in named_files(each).items()}
    if not isinstance(what, Mapping):
        return {}
    files: dict[str, str] = {}
    for key, value in what.items():
        if key in _FOLDERS and isinstance(value, str) and is_folder(value):
            files[value] = fingerprint(Path(value))
        elif key != "name":
            files |= named_files(value)
    return files
