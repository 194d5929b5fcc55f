"""What the inertial and satellite unit of KITTI raw measured: ``oxts/data``, 30 numbers a frame."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.geometry import Floats
from avsec_gym.storage.plain_numbers import plain_number
from avsec_gym.storage.text_files import read_text, write_text


@dataclass(frozen=True, eq=False)
class Oxts:
    """N measurements in the order of KITTI's ``dataformat.txt``, each field of shape (N,).

    The unit's axes: x forward, y left, z up.  Its level axes: forward and leftward parallel to
    the ground, upward.  Accelerations hold the push against gravity, about +9.8 upward.

    Raises:
        ConfigurationError: A shape does not fit, or a value is not finite.
    """

    lat: Floats
    """Latitude, degrees."""
    lon: Floats
    """Longitude, degrees."""
    alt: Floats
    """Altitude, metres."""
    roll: Floats
    """Radians; positive with the left side up."""
    pitch: Floats
    """Radians; positive with the front down."""
    yaw: Floats
    """Radians; 0 is east, positive counter-clockwise."""
    vn: Floats
    """Velocity towards north, m/s."""
    ve: Floats
    """Velocity towards east, m/s."""
    vf: Floats
    """Velocity forward, m/s."""
    vl: Floats
    """Velocity leftward, m/s."""
    vu: Floats
    """Velocity upward, m/s."""
    ax: Floats
    """Acceleration along x, m/s^2."""
    ay: Floats
    """Along y."""
    az: Floats
    """Along z."""
    af: Floats
    """Acceleration forward, m/s^2."""
    al: Floats
    """Leftward."""
    au: Floats
    """Upward."""
    wx: Floats
    """Angular rate about x, rad/s."""
    wy: Floats
    """About y."""
    wz: Floats
    """About z."""
    wf: Floats
    """Angular rate about the forward axis, rad/s."""
    wl: Floats
    """About the leftward axis."""
    wu: Floats
    """About the upward axis."""
    pos_accuracy: Floats
    """Accuracy of the position, metres."""
    vel_accuracy: Floats
    """Accuracy of the velocity, m/s."""
    navstat: Floats
    """Navigation status; 4 is locked."""
    numsats: Floats
    """Satellites in view of the receiver."""
    posmode: Floats
    """Position mode of the receiver."""
    velmode: Floats
    """Velocity mode."""
    orimode: Floats
    """Orientation mode."""

    def __post_init__(self) -> None:
        count = np.size(self.lat)
        for name in FIELDS:
            values = np.asarray(getattr(self, name), np.float64)
            if values.shape != (count,) or not np.isfinite(values).all():
                raise ConfigurationError(
                    f"Oxts.{name} is finite and has shape {(count,)}, got shape {values.shape}"
                )
            object.__setattr__(self, name, values)

    @classmethod
    def from_rows(cls, rows: Floats) -> Oxts:
        """From a table of shape (N, 30) in the order of the fields."""
        table = np.asarray(rows, np.float64)
        if table.ndim != 2 or table.shape[1] != len(FIELDS):
            raise ConfigurationError(f"oxts have shape (N, {len(FIELDS)}), got {table.shape}")
        return cls(*np.ascontiguousarray(table.T))

    @property
    def rows(self) -> Floats:
        """As a table of shape (N, 30)."""
        return np.stack([getattr(self, name) for name in FIELDS], axis=1)

    def __len__(self) -> int:
        return len(self.lat)

    def __getitem__(self, index: Any) -> Oxts:
        """The measurements picked by a mask, a slice or an integer array."""
        return Oxts.from_rows(self.rows[index])


FIELDS = tuple(field.name for field in fields(Oxts))
"""The names of the 30 numbers."""

_FLAGS = 5  # The last five are whole numbers.
_LARGEST = {"lat": 89.9, "lon": 360.0}
_LARGEST_OTHER = 1e6


def read_oxts(paths: str | Path | Iterable[str | Path]) -> Oxts:
    """Measurements from files of one line each.

    Args:
        paths: A file of ``oxts/data``, or several in order.

    Raises:
        DataError: A file has none or several lines, a line has not 30 numbers, or one of them is
            not finite or too large to be true.
    """
    several = [paths] if isinstance(paths, str | Path) else paths
    rows = [_row(path) for path in several]
    return Oxts.from_rows(np.array(rows, np.float64).reshape(len(rows), len(FIELDS)))


def read_oxts_table(path: str | Path) -> Oxts:
    """Measurements of a sequence from one file, a line for each frame, as KITTI tracking has them.

    Raises:
        DataError: There is no line, or one of them is broken, as for `read_oxts`.
    """
    lines = read_text(path).rstrip().split("\n")
    rows = [_numbers(line, path, number) for number, line in enumerate(lines, start=1)]
    return Oxts.from_rows(np.array(rows, np.float64))


def write_oxts(folder: str | Path, oxts: Oxts, *, first: int = 0, overwrite: bool = False) -> None:
    """Write a file for each measurement, lossless.

    Args:
        folder: ``oxts/data`` of a drive.
        oxts: Measurements, one a frame.
        first: The number of the first frame.
        overwrite: Whether files that are there are replaced.

    Raises:
        DataError: A file exists and `overwrite` is false, or cannot be written.
    """
    for number, row in enumerate(oxts.rows.tolist(), start=first):
        words = [repr(value) for value in row[:-_FLAGS]] + [f"{flag:.0f}" for flag in row[-_FLAGS:]]
        path = Path(folder) / f"{number:010d}.txt"
        write_text(path, " ".join(words) + "\n", overwrite=overwrite)


def _row(path: str | Path) -> list[float]:
    lines = read_text(path).rstrip().split("\n")
    if len(lines) > 1 or not lines[0]:
        raise DataError(
            "The file has no line." if not lines[0] else "The file has more than one line.",
            path=path,
            line=1 if not lines[0] else 2,
            remedy="KITTI raw keeps one measurement in each file of oxts/data/.",
        )
    return _numbers(lines[0], path, 1)


def _numbers(line: str, path: str | Path, number: int) -> list[float]:
    words = line.split()
    if len(words) != len(FIELDS):
        raise DataError(
            f"A measurement has {len(FIELDS)} numbers, this one {len(words)}.",
            path=path,
            line=number,
            remedy="The file may be cut off; fetch it again.",
        )
    values = []
    for name, word in zip(FIELDS, words, strict=True):
        try:
            value = plain_number(word)
        except ValueError:
            value = float("nan")
        if not abs(value) <= _LARGEST.get(name, _LARGEST_OTHER):  # Also true for NaN.
            raise DataError(
                f"{name} is {word[:40]!r}, which is no number or too large to be true.",
                path=path,
                line=number,
                remedy="Correct the file, or fetch it again.",
            )
        values.append(value)
    return values
