"""The result of `fit`, as typed rows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from avsec_gym.closed_loop.error_model.check import RangeCheck
from avsec_gym.experiments.json_rows import OPTIONAL, keyed


@dataclass(frozen=True)
class CheckedModel:
    """An error model: what it was fitted to, and how it compares with other drives.

    Args:
        name: The model's name.
        attack: The attack as the registry takes it; empty: none.
        frames: Number of frames that it was fitted to.
        drives: Number of drives that these belong to.
        objects: Number of objects in them.
        found: Number of objects that were detected.
        ghosts: Number of detections of nothing.
        checks: Comparison with drives that it was not fitted to, by distance.
        check_drives: Number of these drives; None: not counted.
    """

    name: str
    attack: Mapping[str, Any] | str
    frames: int
    drives: int
    objects: int
    found: int
    ghosts: int
    checks: Sequence[RangeCheck] = field(metadata=keyed("check"))
    check_drives: int | None = field(default=None, metadata=OPTIONAL)


@dataclass(frozen=True)
class CheckedModels:
    """The error models of all cases."""

    models: Sequence[CheckedModel]
