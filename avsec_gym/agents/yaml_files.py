"""YAML files as dictionaries of plain values: no tag of one makes an object."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from avsec_gym.agents.extras import yaml_module
from avsec_gym.errors import DataError
from avsec_gym.storage.text_files import read_text, write_text

_MOST_BYTES = 2**17
"""rl-zoo3's largest file has 20 kB; PyYAML reads some 50 kB in a second."""
_DEEPEST = 16
_OF_TAGS = (ValueError, TypeError, LookupError, AttributeError, ArithmeticError)
"""What PyYAML raises of a tag whose text is none of its kind, such as ``!!float ''``."""


def read_yaml(path: str | Path, *, remedy: str) -> dict[str, Any]:
    """The mapping in a YAML file.

    Args:
        path: The file.
        remedy: Advice to the user about a damaged one.

    Raises:
        ConfigurationError: PyYAML is not installed.
        DataError: The file cannot be read, is no YAML, or holds something else than a mapping of
            plain values.
    """
    yaml = yaml_module()
    text = read_text(path, most=_MOST_BYTES)
    try:
        if problem := _structure_problem(yaml, text):
            raise DataError(f"The file {problem}.", path=path, remedy=remedy)
        value = yaml.safe_load(text)
    except (yaml.YAMLError, *_OF_TAGS, RecursionError) as error:
        mark = getattr(error, "problem_mark", None)
        line = None if mark is None else mark.line + 1
        problem = getattr(error, "problem", None) or str(error)
        raise DataError(
            f"The file is no sound YAML ({problem}).", path=path, line=line, remedy=remedy
        ) from error
    if not isinstance(value, dict) or not _plain(value):
        raise DataError(
            "The file holds something else than a mapping of names to plain values.",
            path=path,
            remedy=remedy,
        )
    return value


def _structure_problem(yaml: Any, text: str) -> str | None:
    """What is wrong with a file before its values are made, which can take for ever."""
    depth = 0
    for event in yaml.parse(text, yaml.SafeLoader):
        # An alias that stands for itself a thousand times over is never needed here.
        if isinstance(event, yaml.AliasEvent):
            return "has aliases: write them out"
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        if depth > _DEEPEST:
            return f"nests lists and mappings more than {_DEEPEST} deep"
    return None


def write_yaml(path: str | Path, value: Mapping[str, Any]) -> None:
    """Write a mapping of plain values, over what is there."""
    text = yaml_module().safe_dump(dict(value), sort_keys=False, allow_unicode=True)
    write_text(path, text, overwrite=True)


def _plain(value: Any, depth: int = 0) -> bool:
    if depth > _DEEPEST:
        return False
    if isinstance(value, dict):
        return all(isinstance(k, str) and _plain(v, depth + 1) for k, v in value.items())
    if isinstance(value, list):
        return all(_plain(item, depth + 1) for item in value)
    if isinstance(value, float):
        return math.isfinite(value)
    return value is None or isinstance(value, str | int | bool)
