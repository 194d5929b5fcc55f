"""Where a figure stands in a JSON of studies/results."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from avsec_gym.errors import DataError
from avsec_gym.storage.json_files import read_json
from studies.catalogue import STUDIES
from studies.study import RESULTS, ROOT, Study


@dataclass(frozen=True)
class OnlyRow:
    """A step into a list: to its only row whose columns have these values."""

    columns: tuple[tuple[str, str | float | bool | None], ...]

    def __str__(self) -> str:
        return "[" + ", ".join(f"{name}={value}" for name, value in self.columns) + "]"


def row(**columns: str | float | bool | None) -> OnlyRow:
    """The step to the only row of a list whose columns have these values."""
    return OnlyRow(tuple(columns.items()))


@dataclass(frozen=True)
class ResultField:
    """A value in a result.

    Args:
        result: The file's name without its ending, such as ``believed``.
        steps: The way to it: a key, a place in a list, or an `OnlyRow` of a list.
    """

    result: str
    steps: tuple[str | int | OnlyRow, ...]

    def __str__(self) -> str:
        way = "".join(f"{step}" if isinstance(step, OnlyRow) else f".{step}" for step in self.steps)
        return f"{self.result}.json: {way.removeprefix('.')}"

    def then(self, *steps: str | int | OnlyRow) -> ResultField:
        """The value to which these steps lead from here."""
        return ResultField(self.result, (*self.steps, *steps))


def field(result: str, *steps: str | int | OnlyRow) -> ResultField:
    """The value to which these steps lead in a result."""
    return ResultField(result, steps)


def study_of(result: str) -> Study:
    """The study that writes a result.

    Args:
        result: The file's name without its ending.

    Raises:
        DataError: No study of the catalogue writes it.
    """
    for study in STUDIES.values():
        if f"{RESULTS}/{result}.json" in study.writes:
            return study
    raise DataError(f"No study writes {result}.json.", remedy="Add it to studies/catalogue.toml.")


def is_made(result: str, root: Path = ROOT) -> bool:
    """Whether the file of a result is there.

    Args:
        result: The file's name without its ending.
        root: Root of the checkout.
    """
    return _path(result, root).is_file()


def value_at(place: ResultField, root: Path = ROOT) -> object:
    """The value of a field.

    Args:
        place: Where it stands.
        root: Root of the checkout.

    Raises:
        DataError: The file is missing or damaged, or holds no such field.
    """
    path = _path(place.result, root)
    value = _content(path, path.stat().st_mtime_ns if path.is_file() else 0)
    for step in place.steps:
        value = _next(value, step, place, root)
    return value


def number_at(place: ResultField, root: Path = ROOT) -> float | None:
    """The number in a field; None where it holds null.

    Args:
        place: Where it stands.
        root: Root of the checkout.

    Raises:
        DataError: The field is missing, or holds something else.
    """
    value = value_at(place, root)
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise _no_field(place, root, "a number")
    return float(value)


def bounds_at(place: ResultField, root: Path = ROOT) -> tuple[float, float] | None:
    """The interval in a field, low and high; None where it holds null.

    Args:
        place: Where it stands.
        root: Root of the checkout.

    Raises:
        DataError: The field is missing, or holds something else.
    """
    match value_at(place, root):
        case None:
            return None
        case [float() | int() as low, float() | int() as high]:
            return float(low), float(high)
    raise _no_field(place, root, "an interval")


def _next(value: object, step: str | int | OnlyRow, place: ResultField, root: Path) -> object:
    """What a step leads to."""
    match step, value:
        case OnlyRow(), list():
            rows = [each for each in value if _has(each, step)]
            if len(rows) == 1:
                return rows[0]
        case str(), dict() if step in value:
            return value[step]
        case int(), list() if step < len(value):
            return value[step]
    raise _no_field(place, root, f"anything, or one thing alone, at {step}")


def _has(value: object, step: OnlyRow) -> bool:
    return isinstance(value, Mapping) and all(
        name in value and value[name] == wanted for name, wanted in step.columns
    )


def _no_field(place: ResultField, root: Path, wanted: str) -> DataError:
    return DataError(
        f"{place} holds not {wanted}.",
        path=_path(place.result, root),
        remedy="Correct the field where it is named, or make the study anew.",
    )


def _path(result: str, root: Path) -> Path:
    return root / RESULTS / f"{result}.json"


@cache
def _content(path: Path, changed: int) -> object:
    """The JSON, read once for each time of change."""
    return read_json(path, remedy="Make its study: see `python -m studies`.")
