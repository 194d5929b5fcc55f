"""``timestamps.txt`` of KITTI raw: when each frame was recorded, to the nanosecond."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.storage.text_files import read_text, write_text

Timestamps = NDArray[np.datetime64]
"""Shape (N,), ``datetime64[ns]``; NaT where a frame has none."""

# Nanoseconds of 64 bits begin in 1677 and end in 2262, and wrap around beyond.
_STAMP = re.compile(
    r"(?:19|20|21)[0-9]{2}-[0-9]{2}-[0-9]{2} "
    r"[0-9]{2}:[0-9]{2}:[0-9]{2}(\.[0-9]{1,9})?"
)


def read_timestamps(path: str | Path) -> Timestamps:
    """The time of each frame, in the clock of the recording.

    Args:
        path: A file with a line such as ``2011-09-26 13:02:25.964389445`` for each frame, counted
            from 0; a blank line before the last is a frame without a time, as KITTI has them
            where scans were lost.

    Returns:
        Shape (N,), ``datetime64[ns]``, NaT for blank lines.

    Raises:
        DataError: A line is no time, or there is none.

    Example:
        >>> from tempfile import TemporaryDirectory
        >>> times = np.datetime64("2026-01-01T12:00", "ns") + 100_000_000 * np.arange(3)
        >>> with TemporaryDirectory() as folder:
        ...     write_timestamps(f"{folder}/timestamps.txt", times)
        ...     bool((read_timestamps(f"{folder}/timestamps.txt") == times).all())
        True
    """
    lines = [line.strip() for line in read_text(path).rstrip().split("\n")]
    if lines == [""]:
        raise DataError("There is no time in the file.", path=path, remedy="Fetch it again.")
    times = np.full(len(lines), "NaT", "datetime64[ns]")
    for i, line in enumerate(lines):
        if line:
            times[i] = _time(line, path, i + 1)
    return times


def write_timestamps(path: str | Path, times: Timestamps, *, overwrite: bool = False) -> None:
    """Write a line for each frame, lossless; KITTI's own files come out byte for byte.

    Raises:
        ConfigurationError: Not times, none, or the last one unknown.
        DataError: The file exists and `overwrite` is false, or cannot be written.
    """
    times = np.asarray(times)
    if times.ndim != 1 or times.dtype.kind != "M" or not len(times) or np.isnat(times[-1]):
        raise ConfigurationError(
            "timestamps are a datetime64 array of shape (N,) that ends with a known time, got "
            f"{times.dtype} of shape {times.shape}"
        )
    words = np.datetime_as_string(times.astype("datetime64[ns]"), unit="ns").tolist()
    lines = ("" if word == "NaT" else word.replace("T", " ") for word in words)
    write_text(path, "".join(line + "\n" for line in lines), overwrite=overwrite)


def _time(line: str, path: str | Path, number: int) -> np.datetime64:
    try:
        if _STAMP.fullmatch(line):
            return np.datetime64(line.replace(" ", "T"), "ns")
    except ValueError:  # Such as a 13th month.
        pass
    raise DataError(
        f"A line holds a time such as 2011-09-26 13:02:25.964389445, this one {line[:80]!r}.",
        path=path,
        line=number,
        remedy="The file may be cut off or damaged; fetch it again.",
    )
