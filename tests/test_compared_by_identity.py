"""Classes that hold arrays are compared by identity: arrays have no one answer to ``==``."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import avsec_gym

PACKAGE = Path(avsec_gym.__file__).parent
ARRAYS = re.compile(
    r"\b(Floats|Integers|Flags|Masks?|NDArray|ndarray|Tensor|Points|Disparity|Images?)\b"
)
"""Types whose ``==`` is an array."""
HOLDERS = re.compile(r"\b(Callable|type)\[.*\]")
"""What only names such types."""

LEFT = {
    "avsec_gym.kitti.matrix_files.MatrixFile",
    "avsec_gym.world.models.buildings.detached._House",
    "avsec_gym.world.models.vehicles.hull.Outline",
}
"""Nothing compares these, and a change of their files would give every rendered data set another
fingerprint."""


@cache
def dataclasses_of_the_package() -> tuple[type, ...]:
    found = []
    for path in sorted(PACKAGE.rglob("*.py")):
        name = ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts)
        if path.name in ("__init__.py", "__main__.py") or "@dataclass" not in path.read_text():
            continue
        try:
            module = import_module(name)
        except ImportError as error:
            if (error.name or "").startswith("avsec_gym"):
                raise
            continue  # What an extra brings.
        found += [value for value in vars(module).values()
                  if isinstance(value, type) and value.__module__ == name
                  and dataclasses.is_dataclass(value)]  # fmt: skip
    return tuple(found)


def holding_arrays() -> Iterator[type]:
    for kind in dataclasses_of_the_package():
        fields: tuple[Any, ...] = dataclasses.fields(kind)
        if any(ARRAYS.search(HOLDERS.sub("", str(field.type))) for field in fields):
            yield kind


def test_classes_of_arrays_are_compared_by_identity() -> None:
    kinds = list(holding_arrays())
    assert len(kinds) > 100
    wrong = {f"{kind.__module__}.{kind.__name__}" for kind in kinds
             if kind.__dataclass_params__.eq}  # type: ignore[attr-defined]  # fmt: skip
    assert wrong == LEFT, "@dataclass(frozen=True, eq=False)"


def test_why() -> None:
    @dataclasses.dataclass(frozen=True)
    class Two:
        values: np.ndarray

    with pytest.raises(ValueError, match="ambiguous"):
        _ = Two(np.zeros(2)) == Two(np.zeros(2))
