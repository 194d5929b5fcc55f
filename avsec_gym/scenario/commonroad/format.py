"""What reading and writing share: quiet imports of commonroad-io, and the mark of our own notes."""

from __future__ import annotations

import math
import warnings
from functools import cache
from importlib import import_module
from typing import Any

import numpy as np

MARK = "avsec-gym "
"""Begins the ``source`` attribute of files that this project wrote; JSON follows."""


@cache
def import_quietly() -> None:
    """commonroad-io's protobuf warns as it is imported, of what users cannot change."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import_module("commonroad.common.file_reader")
        import_module("commonroad.common.file_writer")


def points_of(vertices: Any) -> tuple[tuple[float, float], ...]:
    """Vertices as plain numbers; a third coordinate is dropped."""
    return tuple((finite(x), finite(y)) for x, y in np.asarray(vertices)[:, :2])


def finite(value: Any) -> float:
    """A plain number.

    Raises:
        ValueError: It is infinite or not a number.
    """
    number = float(value)
    if not math.isfinite(number):
        raise ValueError(f"the number {number} in it")
    return number
