"""`DriveFilm`: all that is shown of a drive, instant by instant; it is kept as one file."""

from __future__ import annotations

import io
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import DataError
from avsec_gym.geometry import Floats
from avsec_gym.storage.npz_files import read_npz

_MOST_BYTES = 2**28
_REMEDY = (
    "Take the file and its drive's line in drives.jsonl away; with --resume the drive is driven "
    "again."
)


@dataclass(frozen=True, eq=False)
class DriveFilm:
    """T instants of a drive among N actors, in the world frame; arrays only.

    Args:
        times: Seconds since the start, shape (T,).
        car: x, y, velocity, heading, steering angle of the car, shape (T, 5).
        braking: Deceleration that led to each instant, m/s2, shape (T,).
        ways: Where the road leads at the car, radians, shape (T,).
        sizes: Length and width of each actor, metres, shape (N, 2).
        poses: x, y, heading of each actor, shape (T, N, 3).
        present: Whether each is there, shape (T, N).
        believed: x, y, heading, length, width of every believed object, shape (B, 5).
        believed_at: The instant of each, shape (B,).
        plans: Points of all plans, shape (P, 2).
        plan_of: The number of the plan that each point belongs to, shape (P,).
        planned: The number of the plan that is followed at each instant; -1: none, shape (T,).
        stops: Whether the plan of each instant is an emergency stop, shape (T,).
        bounds: Points of all lanes' bounds, shape (V, 2).
        bound_of: The number of the bound of each point: 2 i left, 2 i + 1 right of lane i, (V,).
        goal: Both ends of the line that the car is to cross, shape (2, 2).
        contact: The row of the actor that the drive's collision touches, shape (1,); -1: none.
    """

    times: Floats
    car: Floats
    braking: Floats
    ways: Floats
    sizes: Floats
    poses: Floats
    present: NDArray[np.bool_]
    believed: Floats
    believed_at: NDArray[np.int64]
    plans: Floats
    plan_of: NDArray[np.int64]
    planned: NDArray[np.int64]
    stops: NDArray[np.bool_]
    bounds: Floats
    bound_of: NDArray[np.int64]
    goal: Floats
    contact: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.times)

    def content(self) -> bytes:
        """The file's bytes: the same for the same film; places to a tenth of a millimetre."""
        arrays = {}
        for each in fields(self):
            array = getattr(self, each.name)
            arrays[each.name] = array.round(4) if array.dtype.kind == "f" else array
        buffer = io.BytesIO()
        np.savez_compressed(buffer, **arrays)
        return buffer.getvalue()

    def lanes(self) -> list[Floats]:
        """The outline of each lane, shape (V, 2)."""
        sides = [
            self.bounds[self.bound_of == n] for n in range(int(self.bound_of.max(initial=-1)) + 1)
        ]
        return [
            np.vstack([left, right[::-1]])
            for left, right in zip(sides[::2], sides[1::2], strict=True)
        ]

    def at(self, time: float) -> int:
        """The last instant that is not after a time."""
        return max(int(np.searchsorted(self.times, time + 1e-6)) - 1, 0)


def read_film(path: Path) -> DriveFilm:
    """The film in a file.

    Raises:
        DataError: The file is missing, damaged, or of another version.
    """
    arrays = read_npz(path, most=_MOST_BYTES, remedy=_REMEDY)
    names = [each.name for each in fields(DriveFilm)]
    if set(arrays) != set(names) or len({len(arrays[name]) for name in ("times", "car")}) != 1:
        raise DataError("This is no film of a drive.", path=path, remedy=_REMEDY)
    return DriveFilm(**arrays)
