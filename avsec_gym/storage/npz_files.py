"""NumPy's ``.npz`` from strangers: plain arrays of a bounded size, nothing pickled."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import DataError
from avsec_gym.storage.archives import Archive
from avsec_gym.storage.regular_files import MAX_FILE_BYTES, check_regular, read_bytes

_MAGIC = b"\x93NUMPY"
# What every NumPy writes of a plain array: booleans, integers, floating-point numbers, texts.
_HEADER = re.compile(
    rb"\{'descr': '(?P<kind>[<>|=][biufU][0-9]{1,4})', 'fortran_order': (?P<fortran>True|False), "
    rb"'shape': \((?P<shape>[0-9, ]{0,200})\), \} *\n"
)


def read_npz(path: str | Path, *, most: int, remedy: str) -> dict[str, NDArray[Any]]:
    """The arrays of a file by name.

    Args:
        path: The file.
        most: Largest number of bytes of all arrays together; more are not unpacked, whatever the
            file claims.
        remedy: Advice to the user about a damaged file.

    Raises:
        DataError: The file cannot be read, is damaged, larger than that, or holds something else
            than plain arrays.
    """
    archive = Archive(read_bytes(path, most=most), path, most=most, remedy=remedy)
    arrays = {}
    for name in archive.names:
        array = _plain_array(archive.read(name))
        if array is None:
            raise archive.damaged(f"{name[:80]!r} is no plain array")
        arrays[name.removesuffix(".npy")] = array
    return arrays


def map_npy(path: str | Path, *, remedy: str) -> NDArray[Any]:
    """The array of a ``.npy`` file of the package's own cache, mapped: read where it is looked at.

    Args:
        path: The file.
        remedy: Advice to the user about a damaged file.

    Raises:
        DataError: The file cannot be read, is cut off, or holds something else than an array.
    """
    check_regular(path, most=MAX_FILE_BYTES)
    try:
        array = np.load(path, mmap_mode="r", allow_pickle=False)
    except (OSError, EOFError, ValueError) as error:
        raise DataError(f"The array is damaged ({error}).", path=path, remedy=remedy) from error
    return np.asarray(array)


def _plain_array(content: bytes) -> NDArray[Any] | None:
    """The array of a ``.npy`` file; None if it is none, or has not the bytes that it claims."""
    if content[:6] != _MAGIC or content[6:8] not in (b"\x01\x00", b"\x02\x00"):
        return None
    start = 10 if content[6] == 1 else 12
    end = start + int.from_bytes(content[8:start], "little")
    header = _HEADER.fullmatch(content[start:end])
    if header is None:
        return None
    try:
        kind = np.dtype(header["kind"].decode())
        shape = tuple(int(word) for word in header["shape"].split(b",") if word.strip())
    except (TypeError, ValueError):
        return None
    if (
        not kind.itemsize
        or len(shape) > 8
        or math.prod(shape) * kind.itemsize != len(content) - end
    ):
        return None
    # Zero extents beside huge ones pass the test of the bytes.
    if max(shape, default=0) > len(content):
        return None
    array = np.frombuffer(content, kind, offset=end).copy()
    return array.reshape(shape[::-1]).T if header["fortran"] == b"True" else array.reshape(shape)
