"""The one door to files: regular ones only, and never more of them than is asked for.

A path that a user gives may lead to anything: a named pipe blocks the process that opens it, a link
to ``/dev/zero`` fills the memory, a folder or a name of a thousand characters ends in an error of
the system.  All readers of the package go through this module (a test looks for those that do not).
"""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from io import BufferedReader
from pathlib import Path

from avsec_gym.errors import DataError

MAX_TEXT_BYTES = 16 * 2**20
"""KITTI's text files have a few kilobytes; what is larger than this is something else."""

MAX_FILE_BYTES = 2**40
"""The most bytes of files that are read piece by piece, for their hash."""

_FLAGS = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
_NOWHERE = (errno.ENOENT, errno.ENOTDIR, errno.ENAMETOOLONG, errno.ELOOP)
_KINDS = {
    stat.S_IFDIR: "a folder",
    stat.S_IFIFO: "a named pipe",
    stat.S_IFSOCK: "a socket",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
}


@contextmanager
def open_regular(path: str | Path, *, most: int) -> Iterator[BufferedReader]:
    """Open a regular file for reading.

    Args:
        path: The file, or a link to it.
        most: Largest number of bytes of such a file.

    Raises:
        DataError: There is no such file, it is a folder, a pipe or a device, it is larger than
            that, or the system does not let us open it or read on.
    """
    try:
        # Looked at before it is opened: opening alone wakes a process that writes to a pipe.
        _check(path, os.stat(path), most)
        with os.fdopen(os.open(path, _FLAGS), "rb") as file:
            _check(path, os.fstat(file.fileno()), most)
            yield file
    except (OSError, ValueError) as error:
        raise _unreadable(path, error) from error


def read_bytes(path: str | Path, *, most: int) -> bytes:
    """All of a regular file.

    Args:
        path: The file.
        most: Largest number of bytes of such a file.

    Raises:
        DataError: As of `open_regular`.
    """
    with open_regular(path, most=most) as file:
        size = os.fstat(file.fileno()).st_size
        content = file.read(size + 1) or b""
        if len(content) > size:  # It grows, or is one of /proc, which report no sizes.
            content += file.read(most + 1 - len(content)) or b""
    if len(content) > most:
        raise _too_large(path, len(content), most)
    return content


def read_text(path: str | Path, *, most: int = MAX_TEXT_BYTES) -> str:
    """The text of a UTF-8 file.

    Args:
        path: The file.
        most: Largest number of bytes of such a file.

    Raises:
        DataError: As of `open_regular`, or it is not UTF-8.
    """
    content = read_bytes(path, most=most)
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError as error:
        raise DataError(
            f"The byte 0x{content[error.start]:02x} is not UTF-8 text.",
            path=path,
            line=content.count(b"\n", 0, error.start) + 1,
            remedy="The file may be binary, compressed or damaged; fetch it again.",
        ) from error


def check_regular(path: str | Path, *, most: int) -> int:
    """Check a file that a library opens by its name.

    Args:
        path: The file.
        most: Largest number of bytes of such a file.

    Returns:
        Its size in bytes.

    Raises:
        DataError: As of `open_regular`.
    """
    try:
        status = os.stat(path)
        _check(path, status, most)
    except (OSError, ValueError) as error:
        raise _unreadable(path, error) from error
    return status.st_size


def append_line(path: str | Path, line: str) -> None:
    """Write a line at the end of a text file, which is made where it lacks.

    Args:
        path: The file.
        line: The line, without its line break.

    Raises:
        DataError: It is a folder, a pipe or a device, or cannot be written.
    """
    if is_there(path):
        check_regular(path, most=MAX_FILE_BYTES)
    flags = os.O_WRONLY | os.O_APPEND | os.O_CREAT | getattr(os, "O_NONBLOCK", 0)
    try:
        with os.fdopen(os.open(path, flags, 0o666), "a", encoding="utf-8") as file:
            _check(path, os.fstat(file.fileno()), MAX_FILE_BYTES)
            file.write(f"{line}\n")
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise DataError(
            f"The file cannot be written ({reason}).",
            path=path,
            remedy="Check the path, its permissions and the free space.",
        ) from error


def is_file(path: str | Path) -> bool:
    """Whether there is a regular file; not under a name that no file can have.

    Raises:
        DataError: The system does not let us look.
    """
    return stat.S_ISREG(_mode(path))


def is_folder(path: str | Path) -> bool:
    """Whether there is a folder; not under a name that no folder can have.

    Raises:
        DataError: The system does not let us look.
    """
    return stat.S_ISDIR(_mode(path))


def is_there(path: str | Path) -> bool:
    """Whether there is anything under this name; see `is_file`."""
    return _mode(path) != 0


def _mode(path: str | Path) -> int:
    """Of what is there; 0 where nothing is."""
    try:
        return os.stat(path).st_mode
    except ValueError:  # A NUL, or a character that the system's names cannot have.
        return 0
    except OSError as error:
        if error.errno in _NOWHERE:
            return 0
        raise _unreadable(path, error) from error


def _check(path: str | Path, status: os.stat_result, most: int) -> None:
    if not stat.S_ISREG(status.st_mode):
        kind = _KINDS.get(stat.S_IFMT(status.st_mode), "something else")
        raise DataError(
            f"This is {kind}, not a file.",
            path=path,
            remedy="Name a regular file, or a link to it.",
        )
    if status.st_size > most:
        raise _too_large(path, status.st_size, most)


def _too_large(path: str | Path, size: int, most: int) -> DataError:
    return DataError(
        f"The file has {size} bytes, such a file at most {most}.",
        path=path,
        remedy="It is something else, or damaged; check the path.",
    )


def _unreadable(path: str | Path, error: OSError | ValueError) -> DataError:
    if isinstance(error, ValueError):
        problem, remedy = "No file can have this name.", "Check the path."
    elif error.errno == errno.ENAMETOOLONG:
        problem, remedy = "No file can have a name as long as this.", "Check the path."
    elif error.errno in (errno.ENOENT, errno.ENOTDIR):
        problem, remedy = "There is no such file.", "Check the path and the download."
    else:
        problem = f"The file cannot be read ({error.strerror or error})."
        remedy = "Check the path, its permissions and the disk."
    return DataError(problem, path=path, remedy=remedy)
