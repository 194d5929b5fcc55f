"""Point clouds in PCD files, version 0.7, ``ascii`` or ``binary``: the format of PCL and Open3D.

A header of text lines names the fields of a point, with their sizes and types; after the line
``DATA`` come the points. https://pointclouds.org/documentation/tutorials/pcd_file_format.html
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import DataError
from avsec_gym.frame import Points
from avsec_gym.kitti.sensor_files import FARTHEST_POINT
from avsec_gym.storage.regular_files import read_bytes

MAX_PCD_BYTES = 256 * 2**20
"""A scan of 64 rings has 2 MB in binary, 5 MB in ASCII."""
MOST_PCD_POINTS = 5_000_000
_LONGEST_HEADER = 4096
_MOST_FIELDS = 32
_MOST_NUMBERS = 64
"""Numbers that a point has in all its fields together."""
_SIZES = {"F": (4, 8), "I": (1, 2, 4, 8), "U": (1, 2, 4, 8)}
"""Bytes of the numbers of each type."""
_REMEDY = "Write it anew, for instance with Open3D: `write_point_cloud(path, cloud)`."


def read_pcd(path: str | Path) -> Points:
    """The points of a PCD file, in the frame that the file has.

    Points without coordinates (NaN), which stand for rays without a return, are left out. The
    reflectance is the field ``intensity``, else the red of ``rgb``, where Open3D's users keep it
    (OPV2V does), else 0.

    Args:
        path: The file.

    Returns:
        x, y, z in metres and reflectance from 0 to 1, shape (M, 4).

    Raises:
        DataError: Missing, cut off, compressed, no PCD file, or points that no LiDAR measures.
    """
    content = read_bytes(path, most=MAX_PCD_BYTES)
    try:
        layout, body = _header(content)
        table = layout.from_text(body) if layout.is_text else layout.from_binary(body)
        return _points(table)
    except _BrokenError as error:
        raise DataError(f"{error}.", path=path, remedy=error.remedy) from error


class _BrokenError(Exception):
    """What is wrong with a file, and what to do about it."""

    def __init__(self, problem: str, remedy: str = _REMEDY) -> None:
        super().__init__(problem)
        self.remedy = remedy


@dataclass(frozen=True)
class _Layout:
    """How the points of a file lie in its bytes."""

    dtype: np.dtype[np.void]
    points: int
    is_text: bool

    def from_binary(self, body: bytes) -> NDArray[np.void]:
        expected = self.points * self.dtype.itemsize
        if len(body) != expected:
            raise _BrokenError(
                f"Its {self.points} points take {expected} bytes, and {len(body)} follow the header"
            )
        return np.frombuffer(body, self.dtype)

    def from_text(self, body: bytes) -> NDArray[np.void]:
        words = body.split()
        row = sum(int(np.prod(self.dtype[name].shape)) for name in self.dtype.names or ())
        if len(words) != self.points * row:
            raise _BrokenError(
                f"Its {self.points} points of {row} numbers take {self.points * row} numbers, and "
                f"{len(words)} follow the header"
            )
        try:
            if b"_" in body:  # Python groups digits so, files do not.
                raise ValueError("digits that are grouped")
            numbers = np.array(words, dtype="S").astype(np.float64).reshape(self.points, row)
        except ValueError as error:
            raise _BrokenError(f"It holds what is no number ({str(error)[:80]})") from error
        table = np.empty(self.points, self.dtype)
        column = 0
        for name in self.dtype.names or ():
            shape = self.dtype[name].shape
            width = int(np.prod(shape))
            values = numbers[:, column : column + width]
            base = self.dtype[name].base
            if base.kind in "iu":
                limits = np.iinfo(base)
                # Comparisons are false for NaN.
                if not ((values >= limits.min) & (values <= limits.max)).all():
                    raise _BrokenError(f"A value of {name} has no place in {base.itemsize} bytes")
            with np.errstate(over="ignore", invalid="ignore"):
                table[name] = values.astype(base).reshape(self.points, *shape)
            column += width
        return table


def _header(content: bytes) -> tuple[_Layout, bytes]:
    """The layout that the header describes, and the bytes behind it."""
    # The lines up to DATA, key by key.
    entries: dict[str, list[str]] = {}
    place = 0
    while "DATA" not in entries:
        end = content.find(b"\n", place, _LONGEST_HEADER)
        if end < 0:
            raise _BrokenError("It does not begin with the header of a PCD file")
        line = content[place:end].decode("ascii", "replace").strip()
        place = end + 1
        if line and not line.startswith("#"):
            key, *words = line.split()
            if key in entries:
                raise _BrokenError(f"Its header has {key[:20]!r} twice")
            entries[key] = words
    # How the points are written.
    way = " ".join(entries["DATA"])
    if way == "binary_compressed":
        raise _BrokenError(
            "Its points are compressed, which is not read",
            "Write it uncompressed: `pcl_convert_pcd_ascii_binary IN OUT 1`, or with Open3D "
            "`write_point_cloud(path, cloud, compressed=False)`.",
        )
    if way not in ("ascii", "binary"):
        raise _BrokenError(f"Its points are {way[:40]!r}, neither ascii nor binary")
    # What a point is made of, and how many there are.
    fields = entries.get("FIELDS", [])
    sizes = _whole_numbers(entries, "SIZE", len(fields))
    counts = _whole_numbers(entries, "COUNT", len(fields), default=1)
    types = entries.get("TYPE", [])
    if not 3 <= len(fields) <= _MOST_FIELDS or len(types) != len(fields):
        raise _BrokenError("Its header names no fields, or not each with a type")
    if not all(1 <= count <= _MOST_NUMBERS for count in counts) or sum(counts) > _MOST_NUMBERS:
        raise _BrokenError(f"A point has more than {_MOST_NUMBERS} numbers")
    [width], [height] = _whole_numbers(entries, "WIDTH", 1), _whole_numbers(entries, "HEIGHT", 1)
    [points] = _whole_numbers(entries, "POINTS", 1, default=width * height)
    if points != width * height or points > MOST_PCD_POINTS:
        raise _BrokenError(
            f"It promises {points} points and {width} x {height}, and {MOST_PCD_POINTS} are read at"
            " most"
        )
    # The type of a row.
    columns = []
    for index, (kind, size, count) in enumerate(zip(types, sizes, counts, strict=True)):
        if size not in _SIZES.get(kind, ()):
            raise _BrokenError(
                f"The field {fields[index][:20]!r} has {size} bytes of {kind[:20]!r}"
            )
        # Padding fields are all called `_`: a number makes their names different.
        name = f"_{index}" if fields[index] in ("_", *fields[:index]) else fields[index]
        columns.append((name, f"<{kind.lower()}{size}", (count,)))
    return _Layout(np.dtype(columns), points, way == "ascii"), content[place:]


def _whole_numbers(
    entries: dict[str, list[str]], key: str, count: int, default: int | None = None
) -> list[int]:
    if key not in entries and default is not None:
        return [default] * count
    words = entries.get(key, [])
    if len(words) != count or not all(word.isdecimal() and len(word) < 12 for word in words):
        raise _BrokenError(f"Its header has no {key} of {count} whole numbers")
    return [int(word) for word in words]


def _points(table: NDArray[np.void]) -> Points:
    names = table.dtype.names or ()
    if any(name not in names for name in "xyz"):
        raise _BrokenError("Its points have no x, y and z")
    columns = [table[name][:, 0].astype(np.float64) for name in "xyz"]
    places = np.stack(columns, axis=1)
    reflectance = _reflectance(table)
    returned = ~np.isnan(places).any(axis=1)
    places, reflectance = places[returned], reflectance[returned]
    if not (np.abs(places) <= FARTHEST_POINT).all():
        raise _BrokenError(f"A point is beyond {FARTHEST_POINT:g} m")
    if not ((reflectance >= 0) & (reflectance <= 1)).all():
        raise _BrokenError(
            "An intensity is not from 0 to 1",
            "Divide the intensities by their largest possible value, such as 255.",
        )
    return np.column_stack([places, reflectance]).astype(np.float32)


def _reflectance(table: NDArray[np.void]) -> NDArray[np.float64]:
    names = table.dtype.names or ()
    if "intensity" in names:
        return table["intensity"][:, 0].astype(np.float64)
    packed = next((name for name in ("rgb", "rgba") if name in names), None)
    if packed is None or table.dtype[packed].base.itemsize != 4:
        return np.zeros(len(table))
    # Four bytes 0, red, green, blue from the highest down, whatever number they are taken for.
    colour = np.ascontiguousarray(table[packed][:, 0]).view(np.uint32)
    return (colour >> 16 & 255) / 255.0
