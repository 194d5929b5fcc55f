"""JSON objects as dataclasses: each value has the type of its field, or the file is refused."""

from __future__ import annotations

import types
from collections.abc import Mapping
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any, TypeVar, Union, get_args, get_origin, get_type_hints

from avsec_gym.errors import DataError
from avsec_gym.storage.json_files import read_json_object

Fields = TypeVar("Fields")


def read_fields(kind: type[Fields], path: str | Path, *, remedy: str) -> Fields:
    """The dataclass that a JSON file describes; names that it lacks are left alone.

    Args:
        kind: A dataclass of plain values, lists and dictionaries.
        path: The file.
        remedy: Advice to the user about a damaged one.

    Raises:
        DataError: The file cannot be read, a field is missing, or a value has another type.
    """
    # Metrics of a training that failed are NaN, as Python writes it.
    facts = read_json_object(path, remedy=remedy, finite=False)
    try:
        return kind(**fitting_fields(kind, facts))
    except (TypeError, ValueError) as error:
        raise DataError(
            f"This describes no {kind.__name__}: {error}.", path=path, remedy=remedy
        ) from error


def fitting_fields(kind: type[Any], facts: Mapping[str, Any]) -> dict[str, Any]:
    """The values for a dataclass among others, each of its field's type.

    Raises:
        ValueError: One is missing, or has another type; which one.

    Example:
        >>> from dataclasses import make_dataclass
        >>> fitting_fields(make_dataclass("Size", [("width", int)]), {"width": 3, "by": "hand"})
        {'width': 3}
    """
    hints = get_type_hints(kind)
    values = {}
    for field in fields(kind):
        if field.name not in facts:
            if field.default is MISSING and field.default_factory is MISSING:
                raise ValueError(f"it lacks {field.name}")
            continue
        value = facts[field.name]
        if not fits(value, hints[field.name]):
            raise ValueError(f"{field.name} is {_shown(value)}, not what is written there")
        values[field.name] = value
    return values


def fits(value: Any, kind: Any) -> bool:
    """Whether a value of JSON has a type such as ``dict[str, list[float]]`` or ``int | None``."""
    if kind is Any:
        return True
    origin, parts = get_origin(kind), get_args(kind)
    if origin in (Union, types.UnionType):
        return any(fits(value, part) for part in parts)
    if origin in (dict, Mapping):
        return isinstance(value, dict) and all(fits(item, parts[1]) for item in value.values())
    if origin is list:
        return isinstance(value, list) and all(fits(item, parts[0]) for item in value)
    if kind is float:
        return isinstance(value, (int, float)) and not isinstance(value, bool)
    if kind is int:
        return type(value) is int
    return isinstance(value, type(None) if kind is None else kind)


def _shown(value: Any) -> str:
    if isinstance(value, (dict, list)):
        return f"a JSON {'object' if isinstance(value, dict) else 'list'}"
    return f"{value!r:.40}"
