"""`DriveFilm`: all that is shown of a drive, instant by instant; it is kept as one file."""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import DataError
from avsec_gym.geometry import Floats
from avsec_gym.scenario.planning_scenario import EgoState
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
        arrays: dict[str, Any] = {}
        for each in fields(self):
            array = np.ascontiguousarray(getattr(self, each.name))
            # Zero has one sign: which one a sum has depends on the plane that it is made in.
            arrays[each.name] = array.round(4) + 0.0 if array.dtype.kind == "f" else array
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

    def replannings(self) -> list[tuple[float, EgoState]]:
        """When each plan was made, seconds since the start, and the state that was reached then."""
        began = np.flatnonzero(np.diff(self.planned) > 0).tolist()
        return [
            (float(self.times[row]), EgoState(*self.car[row].tolist()))
            for row in ([0, *began] if (self.planned >= 0).any() else [])
        ]

    def at(self, time: float) -> int:
        """The last instant that is not after a time."""
        return max(int(np.searchsorted(self.times, time + 1e-6)) - 1, 0)


def read_film(path: Path) -> DriveFilm:
    """The film in a file.

    Raises:
        DataError: The file is missing, damaged, of another version, or holds what no drive does.
    """
    arrays = read_npz(path, most=_MOST_BYTES, remedy=_REMEDY)
    problem = _problem(arrays)
    if problem is not None:
        raise DataError(f"This is no film of a drive: {problem}.", path=path, remedy=_REMEDY)
    return DriveFilm(**arrays)


_FORMS = {
    "times": ("f", "T"),
    "car": ("f", "T 5"),
    "braking": ("f", "T"),
    "ways": ("f", "T"),
    "sizes": ("f", "N 2"),
    "poses": ("f", "T N 3"),
    "present": ("b", "T N"),
    "believed": ("f", "B 5"),
    "believed_at": ("i", "B"),
    "plans": ("f", "P 2"),
    "plan_of": ("i", "P"),
    "planned": ("i", "T"),
    "stops": ("b", "T"),
    "bounds": ("f", "V 2"),
    "bound_of": ("i", "V"),
    "goal": ("f", "2 2"),
    "contact": ("i", "1"),
}
"""Kind and shape of each array; a letter is the same number everywhere."""
_FARTHEST = 1e5
"""Metres from the car's start to anything in its film, at most; drives take seconds.  No speed,
angle or size is larger, either."""
_LONGEST_STEP = 10.0
_HARDEST_BRAKING = 1000.0
"""m/s2, either way: a hundred times what tyres can."""


def _problem(arrays: Mapping[str, NDArray[Any]]) -> str | None:
    """What of the arrays no film holds; None where they are one."""
    if set(arrays) != set(_FORMS):
        return "it has other arrays"
    # Forms: kinds and axes of the arrays, of which those of one letter are equally long.
    extents: dict[str, int] = {}
    for name, (kind, form) in _FORMS.items():
        array, wanted = arrays[name], form.split()
        if array.dtype.kind != kind or array.ndim != len(wanted):
            return f"{name} is of another kind"
        for length, letter in zip(array.shape, wanted, strict=True):
            if length != extents.setdefault(letter, int(letter) if letter.isdecimal() else length):
                return f"{name} is longer or shorter than what belongs to it"
    # Numbers: places near the car, times one after the other, indices of what is there.
    times, start = arrays["times"], arrays["car"][:1, :2]
    if not extents["T"]:
        return "it has no instant"
    for name, (kind, _) in _FORMS.items():
        if kind == "f" and not np.isfinite(arrays[name]).all():
            return f"{name} holds a number that is not finite"
    places = [arrays[name].reshape(-1, arrays[name].shape[-1])[:, :2] for name in _PLACES]
    if any((np.abs(each - start) > _FARTHEST).any() for each in places):
        return "something is farther away than any road leads"
    if (np.abs(arrays["braking"]) > _HARDEST_BRAKING).any():
        return "it brakes as no car can"
    if times[0] < 0 or not ((np.diff(times) > 0) & (np.diff(times) <= _LONGEST_STEP)).all():
        return "its times are not one after the other"
    for name, (kind, _) in _FORMS.items():
        others = arrays[name][..., 2:] if name in _PLACES else arrays[name]
        if kind == "f" and (np.abs(others) > _FARTHEST).any():
            return f"{name} holds a number that no drive has"
    if (arrays["sizes"] < 0).any() or (arrays["believed"][:, 3:] < 0).any():
        return "something is smaller than nothing"
    # Lanes: two bounds each, numbered without gaps.
    bounds = arrays["bound_of"]
    sides = np.unique(bounds)
    if len(sides) % 2 or not np.array_equal(sides, np.arange(len(sides))):
        return "a lane lacks a bound"
    # Indices: of instants, of plans and of actors that are there.
    for name, most in (
        ("believed_at", extents["T"]),
        ("plan_of", extents["T"] + 1),
        ("planned", extents["T"] + 1),
        ("contact", extents["N"]),
    ):
        least = -1 if name in ("planned", "contact") else 0
        if ((arrays[name] < least) | (arrays[name] >= most)).any():
            return f"{name} names what is not there"
    return None


_PLACES = ("car", "poses", "believed", "plans", "bounds", "goal")
