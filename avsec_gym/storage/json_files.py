"""JSON from strangers: bounded in size, depth and numbers, and one kind of error."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any, NoReturn

from avsec_gym.errors import DataError
from avsec_gym.storage.regular_files import read_text

MAX_JSON_BYTES = 128 * 2**20
"""The manifest of a data set of KITTI's size has ten megabytes."""

DEEPEST = 32
"""Lists and dictionaries within each other; the project's own files have six."""

_LARGEST_INTEGER = 2**63


def parse_json(text: str, *, finite: bool = True) -> Any:
    """The value that a JSON text spells.

    Args:
        text: The JSON text.
        finite: Whether NaN and infinity are refused, which Python writes and JSON does not know.

    Raises:
        ValueError: It is no JSON, nested deeper than `DEEPEST`, or holds a number that is not
            finite or an integer of more than 64 bits; the message names it.

    Example:
        >>> parse_json('{"width": 1242}')
        {'width': 1242}
    """
    try:
        value = json.loads(
            text,
            parse_int=_integer,
            parse_float=_number if finite else None,
            parse_constant=_no_number if finite else None,
        )
    except RecursionError:
        raise ValueError(f"lists and dictionaries are nested more than {DEEPEST} deep") from None
    # Level by level: later code may walk through it recursively.
    level, depth = [value], 0
    while level := [item for item in level if isinstance(item, (dict, list))]:
        depth += 1
        if depth > DEEPEST:
            raise ValueError(f"lists and dictionaries are nested more than {DEEPEST} deep")
        level = [
            inner for item in level for inner in (item.values() if isinstance(item, dict) else item)
        ]
    return value


def read_json(
    path: str | Path, *, remedy: str, most: int = MAX_JSON_BYTES, finite: bool = True
) -> Any:
    """The value in a JSON file.

    Args:
        path: The file.
        remedy: Advice to the user about a damaged one.
        most: Largest number of bytes of such a file.
        finite: Whether all numbers must be finite, as of `parse_json`.

    Raises:
        DataError: The file cannot be read, or is no JSON; see `parse_json`.
    """
    text = read_text(path, most=most)
    try:
        return parse_json(text, finite=finite)
    except ValueError as error:
        line = error.lineno if isinstance(error, json.JSONDecodeError) else None
        raise DataError(
            f"The file is no sound JSON ({error}).", path=path, line=line, remedy=remedy
        ) from error


def read_json_object(
    path: str | Path, *, remedy: str, most: int = MAX_JSON_BYTES, finite: bool = True
) -> dict[str, Any]:
    """The dictionary in a JSON file; see `read_json`.

    Raises:
        DataError: As of `read_json`, or the file holds something else than a dictionary.
    """
    value = read_json(path, remedy=remedy, most=most, finite=finite)
    if not isinstance(value, dict):
        raise DataError(
            "The file holds something else than a JSON object.", path=path, remedy=remedy
        )
    return value


def _integer(word: str) -> int:
    if len(word) > 20 or not -_LARGEST_INTEGER <= (value := int(word)) < _LARGEST_INTEGER:
        raise ValueError(f"the number {word[:20]}... is larger than any")
    return value


def _number(word: str) -> float:
    value = float(word)
    if not math.isfinite(value):
        raise ValueError(f"the number {word[:20]} is larger than any")
    return value


def _no_number(word: str) -> NoReturn:
    raise ValueError(f"{word} is no number in JSON")
