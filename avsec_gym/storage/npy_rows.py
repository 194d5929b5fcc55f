"""Large arrays on disk, ``.npy`` files that are written piece by piece.

Never through a memory map: where the disk is full, a page that finds no room there kills the
process (SIGBUS) without a word.  A file that is written reports it.
"""

from __future__ import annotations

import errno
import math
import os
from io import BytesIO, FileIO
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import DTypeLike, NDArray

from avsec_gym.errors import DataError
from avsec_gym.storage.write_errors import naming

_PIECE = 2**20
"""Bytes that are copied, or filled with zeros, at a time."""
_NOT_KNOWN_HERE = (errno.EINVAL, errno.ENOSYS, errno.ENOTSUP, errno.EOPNOTSUPP, errno.ENODEV)
"""What file systems answer that cannot reserve room."""


class NewFile:
    """A new file, in a folder that no one else knows yet; its errors name it.

    Args:
        path: The file, which is not there yet.

    Raises:
        DataError: It cannot be made.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        with naming(self._path):
            self._file = FileIO(path, "x+")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def write(self, content: bytes, place: int | None = None) -> None:
        """Write bytes.

        Args:
            content: The bytes.
            place: Where, in bytes from the beginning; at the end if None.

        Raises:
            DataError: They have no room, or the file cannot be written.
        """
        rest = memoryview(content)
        with naming(self._path):
            self._file.seek(place or 0, os.SEEK_END if place is None else os.SEEK_SET)
            while rest:  # A disk that is nearly full takes a part of them.
                rest = rest[self._file.write(rest) :]

    def copy_to(self, other: NewFile) -> None:
        """Write all of this file at the end of another one.

        Raises:
            DataError: As of `write`, or this one cannot be read.
        """
        with naming(self._path):
            self._file.seek(0)
        while True:
            with naming(self._path):
                piece = self._file.read(_PIECE)
            if not piece:
                return
            other.write(piece)

    def reserve(self, size: int) -> None:
        """Let it have so many bytes, zeros where none was written, each with its place on the disk.

        Args:
            size: Bytes of the whole file.

        Raises:
            DataError: The disk has no room for them.
        """
        with naming(self._path):
            if hasattr(os, "posix_fallocate"):
                try:
                    os.posix_fallocate(self._file.fileno(), 0, size)
                    return
                except OSError as error:
                    if error.errno not in _NOT_KNOWN_HERE:
                        raise
            there = self._file.seek(0, os.SEEK_END)
        for start in range(there, size, _PIECE):
            self.write(bytes(min(_PIECE, size - start)))


class NpyRows(NewFile):
    """A new array on disk, all zeros, with room for all of it from the beginning.

    Args:
        path: The ``.npy`` file, which is not there yet.
        kind: Type of the numbers.
        shape: Shape of the array; its rows are along the first axis.

    Raises:
        DataError: The disk has no room for it, or the file cannot be made.
    """

    def __init__(self, path: Path, kind: DTypeLike, shape: tuple[int, ...]) -> None:
        super().__init__(path)
        self._kind, self._row = np.dtype(kind), shape[1:]
        self._row_bytes = math.prod(self._row) * self._kind.itemsize
        try:
            header = npy_header(self._kind, shape)
            self.write(header)
            self._start = len(header)
            self.reserve(self._start + shape[0] * self._row_bytes)
        except DataError:
            self._file.close()
            raise

    def __setitem__(self, index: int, row: NDArray[Any]) -> None:
        """Write a row in its place.

        Args:
            index: Its number, from 0.
            row: The row, of the shape and type that the array was made with.

        Raises:
            DataError: As of `write`.
        """
        assert row.shape == self._row, "a row has the shape that the array was made with"
        self.write(row.astype(self._kind).tobytes(), self._start + index * self._row_bytes)


def npy_header(kind: DTypeLike, shape: tuple[int, ...]) -> bytes:
    """What stands before the numbers of a ``.npy`` file, which follow row by row.

    Args:
        kind: Type of the numbers.
        shape: Shape of the array.

    Example:
        >>> len(npy_header("<i2", (3, 4)))
        128
    """
    header = BytesIO()
    description = np.lib.format.dtype_to_descr(np.dtype(kind))
    np.lib.format.write_array_header_1_0(
        header, {"descr": description, "fortran_order": False, "shape": shape}
    )
    return header.getvalue()
