"""What else may stand in place of a file: nothing, a folder, a pipe, a device, a loop."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from random import Random

Replacement = Callable[[Path, Random], None]
_LARGE = 64 * 2**30


def missing(path: Path, _: Random) -> None:
    """No such file."""
    path.unlink()


def empty(path: Path, _: Random) -> None:
    """Of no byte."""
    path.write_bytes(b"")


def folder(path: Path, _: Random) -> None:
    """A folder of that name."""
    path.unlink()
    path.mkdir()


def pipe(path: Path, _: Random) -> None:
    """A FIFO that no process writes into."""
    path.unlink()
    os.mkfifo(path)


def device(path: Path, random: Random) -> None:
    """A link to a device that never ends, or blocks."""
    path.unlink()
    path.symlink_to(random.choice(("/dev/zero", "/dev/urandom", "/dev/null", "/dev/full")))


def dangling_link(path: Path, _: Random) -> None:
    """A link to nowhere, or to itself."""
    path.unlink()
    path.symlink_to(path)


def huge(path: Path, _: Random) -> None:
    """The file, and 64 GiB of zeros that take no space on the disk."""
    with path.open("r+b") as file:
        file.truncate(_LARGE)


def random_bytes(path: Path, random: Random) -> None:
    """Something else altogether."""
    path.write_bytes(random.randbytes(random.choice((1, 7, 4096, 100_000))))


def companion(path: Path, random: Random) -> None:
    """A file beside it that a database takes for its own log."""
    other = path.with_name(path.name + random.choice(("-wal", "-journal", "-shm")))
    other.write_bytes(random.randbytes(random.choice((0, 32, 5000))))


REPLACEMENTS: dict[str, Replacement] = {
    replacement.__name__: replacement
    for replacement in (
        missing,
        empty,
        folder,
        pipe,
        device,
        dangling_link,
        huge,
        random_bytes,
        companion,
    )
}
