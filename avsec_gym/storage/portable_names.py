"""Names in records that outlive a process, and its locale.

Under a POSIX locale, Python keeps the bytes of a name that is no ASCII as lone surrogates.  A
record of them is read by a process of UTF-8 as another name; so records hold the name that the
bytes spell in UTF-8, where they do.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from typing import TypeVar

Value = TypeVar("Value")


def portable(value: Value) -> Value:
    """A value of JSON with all texts as a process of UTF-8 would have them.

    Args:
        value: A text, or lists, tuples and mappings that hold some; the rest stays as it is.

    Example:
        >>> portable({"path": "größe".encode().decode("ascii", "surrogateescape")})
        {'path': 'größe'}
    """
    return _with_texts(value, _portable)


def local(value: Value) -> Value:
    """What `portable` made, with all texts as this process has names of files.

    Args:
        value: The value that `portable` made; a record of an earlier release, made under a POSIX
            locale, is taken as well.
    """
    return _with_texts(value, _local)


def _portable(text: str) -> str:
    try:
        return os.fsencode(text).decode("utf-8")
    except UnicodeError:  # Of another encoding, or no name.
        return text


def _local(text: str) -> str:
    text = _portable(text)
    try:
        return os.fsdecode(text.encode("utf-8"))
    except UnicodeError:
        return text


def _with_texts(value: Value, change: Callable[[str], str]) -> Value:
    changed: object = value
    if isinstance(value, str):
        changed = value if value.isascii() else change(value)
    elif isinstance(value, Mapping):
        changed = {
            _with_texts(name, change): _with_texts(each, change) for name, each in value.items()
        }
    elif isinstance(value, (list, tuple)):
        changed = [_with_texts(each, change) for each in value]
        changed = tuple(changed) if isinstance(value, tuple) else changed
    return changed  # type: ignore[return-value]
