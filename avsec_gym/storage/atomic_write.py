"""Files written whole or not at all, and never over another one unasked."""

from __future__ import annotations

import os
import secrets
from pathlib import Path

from avsec_gym.errors import DataError
from avsec_gym.storage.folders import make_folder, named
from avsec_gym.storage.regular_files import is_folder, is_there


def write_bytes(path: str | Path, content: bytes, *, overwrite: bool = False) -> None:
    """Write a file whole or not at all; folders above it are made where they lack.

    Raises:
        DataError: The path is empty, the file exists and `overwrite` is false, or the place cannot
            be written.
    """
    path = named(path)
    if "\0" in str(path):
        raise DataError("No file can have this name.", path=path, remedy="Check the path.")
    temporary = path.with_name(f".{path.name}.{os.getpid()}.{secrets.token_hex(4)}.tmp")
    try:
        if is_there(path) and not overwrite:
            raise DataError(
                "This file exists and is left as it is.",
                path=path,
                remedy="Choose another place, or ask for overwriting.",
            )
        make_folder(path.parent)
        try:
            with open(temporary, "xb") as file:
                file.write(content)
            os.replace(temporary, path)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        if is_folder(path):
            raise DataError(
                "This is a folder, where a file is to be written.",
                path=path,
                remedy="Name another place, or move the folder away.",
            ) from error
        raise DataError(
            f"The file cannot be written ({error}).",
            path=path,
            remedy="Check the folder's permissions and the free space.",
        ) from error
