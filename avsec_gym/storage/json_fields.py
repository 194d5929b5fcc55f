"""JSON objects as dataclasses: each value has the type of its field, or the file is refused."""

from __future__ import annotations

import types
from collections.abc import Mapping
from dataclasses import MISSING, fields
from enum import Enum
from pathlib import Path
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints, is_typeddict

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
            raise _misfit(field.name, value)
        values[field.name] = value
    return values


def check_fields(kind: type[Any], facts: Mapping[str, Any]) -> None:
    """Refuse an object that lacks a field of a typed dictionary, or has another type there.

    Args:
        kind: A `typing.TypedDict`.
        facts: The object; names beside the fields are left alone.

    Raises:
        ValueError: One is missing, or has another type; which one.
    """
    for name, hint in get_type_hints(kind).items():
        if name not in facts:
            if name in kind.__required_keys__:
                raise ValueError(f"it lacks {name}")
        elif not fits(facts[name], hint):
            raise _misfit(name, facts[name])


def fits(value: Any, kind: Any) -> bool:
    """Whether a value of JSON has a type such as ``dict[str, list[float]]`` or ``int | None``.

    An enumeration stands for its values, a typed dictionary for an object with its fields.
    """
    if kind is Any:
        return True
    if is_typeddict(kind):
        try:
            check_fields(kind, value if isinstance(value, dict) else {})
        except ValueError:
            return False
        return isinstance(value, dict)
    origin, parts = get_origin(kind), get_args(kind)
    if origin is Literal:
        return any(type(value) is type(part) and value == part for part in parts)
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
    if isinstance(kind, type) and issubclass(kind, Enum):
        return isinstance(value, (str, int)) and value in [member.value for member in kind]
    return isinstance(value, type(None) if kind is None else kind)


def _misfit(name: str, value: Any) -> ValueError:
    return ValueError(f"{name} is {_shown(value)}, not what is written there")


def _shown(value: Any) -> str:
    if isinstance(value, (dict, list)):
        return f"a JSON {'object' if isinstance(value, dict) else 'list'}"
    return f"{value!r:.40}"
