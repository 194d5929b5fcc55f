"""Rows of results as JSON: a dataclass is an object with a column for each field.

A field with the metadata `FLAT`, and rates of episodes, have their own columns among those of the
row; `keyed` gives a column another key.  What has a method `columns` makes several columns of one
field, and is made of them by `of_columns`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, fields, is_dataclass
from enum import Enum
from types import NoneType
from typing import (
    Any,
    Protocol,
    Self,
    TypeVar,
    get_args,
    get_origin,
    get_type_hints,
    runtime_checkable,
)

from avsec_gym.metrics.safety import SafetyRates

FLAT = {"flat": True}
"""Metadata of a field whose columns stand among those of the row; None has no columns."""
OPTIONAL = {"optional": True}
"""Metadata of a field that is no column where it is None."""

R = TypeVar("R")


@runtime_checkable
class HasColumns(Protocol):
    """What makes several columns of one field."""

    def columns(self, key: str) -> dict[str, object]:
        """The columns of the field that this key names."""
        ...

    @classmethod
    def of_columns(cls, key: str, columns: Mapping[str, Any]) -> Self:
        """The row read back; raises KeyError where a column is missing."""
        ...


def keyed(key: str) -> Mapping[str, str]:
    """Metadata of a field whose key in JSON is no name in Python, or older than the name."""
    return {"key": key}


def row_json(row: object) -> dict[str, object]:
    """A row as JSON.

    Args:
        row: A dataclass.

    Example:
        >>> from avsec_gym.metrics.clustered_shares import share_of
        >>> row_json(share_of([], []))
        {'count': 0, 'of': 0, 'rate': None, 'interval': None}
    """
    assert is_dataclass(row)
    columns: dict[str, object] = {}
    for column in fields(row):
        key, value = column.metadata.get("key", column.name), getattr(row, column.name)
        if value is not None or "optional" not in column.metadata:
            columns |= _columns(key, value, flat="flat" in column.metadata)
    return columns


def as_json(value: object) -> object:
    """The JSON of rows in lists and mappings."""
    if is_dataclass(value):
        return row_json(value)
    if isinstance(value, Mapping):
        return {str(key): as_json(item) for key, item in value.items()}
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [as_json(item) for item in value]
    return value


def row_of(kind: type[R], columns: Mapping[str, Any]) -> R:
    """The row that `row_json` made this JSON of; columns that it does not know are left out.

    Args:
        kind: The dataclass.
        columns: The JSON.  What is absent has the field's default, or None where it may be None.

    Raises:
        KeyError: A column is missing.
        TypeError: A column has another form.
        ValueError: A value is none of its enumeration.
    """
    hints = get_type_hints(kind)
    values: dict[str, Any] = {}
    for column in fields(kind):  # type: ignore[arg-type]
        key, hint = column.metadata.get("key", column.name), hints[column.name]
        if "flat" in column.metadata or hint is SafetyRates:
            values[column.name] = _flat_value(hint, columns)
        elif (several := _has_columns(hint)) is not None:
            values[column.name] = _of_columns(several, key, columns, NoneType in get_args(hint))
        elif key in columns:
            values[column.name] = _value(hint, columns[key])
        elif NoneType in get_args(hint):
            values[column.name] = None
        elif column.default is MISSING:
            raise KeyError(key)
    return kind(**values)


def _columns(key: str, value: object, *, flat: bool) -> dict[str, object]:
    """The columns that a field makes."""
    if isinstance(value, HasColumns):
        return value.columns(key)
    if isinstance(value, SafetyRates):
        return value.to_json()
    if flat and value is None:
        return {}
    if flat and isinstance(value, Mapping):
        return {
            name: number
            for inner, item in value.items()
            for name, number in _columns(inner, item, flat=False).items()
        }
    return row_json(value) if flat else {key: as_json(value)}


def _has_columns(hint: Any) -> type[HasColumns] | None:
    """The class of a field that makes several columns, whether it may be None or not."""
    for member in get_args(hint) if NoneType in get_args(hint) else (hint,):
        if isinstance(member, type) and issubclass(member, HasColumns):
            return member
    return None


def _of_columns(
    kind: type[HasColumns], key: str, columns: Mapping[str, Any], may_be_none: bool
) -> HasColumns | None:
    """The value of several columns; None where it may be None and one of them is missing."""
    try:
        return kind.of_columns(key, columns)
    except KeyError:
        if may_be_none:
            return None
        raise


def _flat_value(hint: Any, columns: Mapping[str, Any]) -> Any:
    """The value of a `FLAT` field; None where it may be None and a column of it is missing."""
    try:
        return _value(hint, columns)
    except KeyError:
        if NoneType in get_args(hint):
            return None
        raise


def _value(hint: Any, found: Any) -> Any:
    """A field's value of its JSON; null stands for NaN where a number is due."""
    if found is None:
        return math.nan if hint is float else None
    if NoneType in (members := get_args(hint)):
        [hint] = [member for member in members if member is not NoneType]
    if is_dataclass(hint):
        assert isinstance(hint, type)
        return row_of(hint, found)
    if isinstance(hint, type) and issubclass(hint, Enum):
        return hint(found)
    if get_origin(hint) in (Sequence, list):
        return [_value(get_args(hint)[0], item) for item in found]
    if get_origin(hint) is tuple:
        return tuple(found)
    if get_origin(hint) is Mapping:
        if not isinstance(found, Mapping):
            raise TypeError(f"{found!r:.40} is no object of JSON")
        return {key: _value(get_args(hint)[1], item) for key, item in found.items()}
    return found
