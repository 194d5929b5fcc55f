"""ZIP archives from strangers, whose members are unpacked up to a bound, into memory."""

from __future__ import annotations

import io
import struct
import zipfile
import zlib
from pathlib import Path

from avsec_gym.errors import DataError

# What `zipfile` raises over the damage that it meets, beside an error of its own: unknown methods
# of compression, passwords, sizes beyond the end, names that are no text.
_DAMAGE = (
    zipfile.BadZipFile,
    zlib.error,
    struct.error,
    NotImplementedError,
    RuntimeError,
    EOFError,
    OSError,
    OverflowError,
    ValueError,
)
_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)


class Archive:
    """A ZIP archive in memory.

    Args:
        content: Content of the file.
        path: Path of the file, for messages.
        most: Largest number of bytes that all members that are read have together, unpacked.
        remedy: Advice to the user about a damaged one.

    Raises:
        DataError: It is no ZIP archive, or damaged.
    """

    def __init__(self, content: bytes, path: str | Path, *, most: int, remedy: str) -> None:
        self._path, self._left, self._remedy = path, most, remedy
        try:
            self._archive = zipfile.ZipFile(io.BytesIO(content))
            self.names = tuple(self._archive.namelist())
        except _DAMAGE as error:
            raise self.damaged(error) from error

    def read(self, name: str) -> bytes:
        """The content of a member, its checksum right.

        Raises:
            DataError: There is none of this name, it is damaged, encrypted or packed in an unusual
                way, or too much has been read.
        """
        try:
            member = self._archive.getinfo(name)
        except KeyError:
            raise self.damaged(f"it lacks {name}") from None
        if member.compress_type not in _METHODS:
            raise self.damaged(f"{name} is packed by the unknown method {member.compress_type}")
        if member.file_size > self._left:
            raise self.damaged(f"{name} claims {member.file_size} bytes")
        try:
            with self._archive.open(member) as file:
                content = file.read(self._left + 1)
        except _DAMAGE as error:
            raise self.damaged(error) from error
        if len(content) != member.file_size:
            raise self.damaged(f"{name} has not the {member.file_size} bytes that it claims")
        self._left -= len(content)
        return content

    def damaged(self, why: object) -> DataError:
        """The error for this file."""
        return DataError(f"The archive is damaged ({why}).", path=self._path, remedy=self._remedy)
