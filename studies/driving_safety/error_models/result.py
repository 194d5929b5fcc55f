"""The result of `fit`, as typed rows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from avsec_gym.closed_loop.error_model.check import RangeCheck


@dataclass(frozen=True)
class CheckedModel:
    """An error model: what it was fitted to, and how it compares with other drives.

    Args:
        name: The model's name.
        attack: The name of the attack; empty: none.
        drives: Number of drives that it was fitted to.
        frames: Number of frames of them.
        objects: Number of objects in them.
        found: Number of objects that were detected.
        ghosts: Number of detections of nothing.
        checks: Comparison with drives that it was not fitted to, by distance.
    """

    name: str
    attack: str
    drives: int
    frames: int
    objects: int
    found: int
    ghosts: int
    checks: tuple[RangeCheck, ...]

    @classmethod
    def of(cls, row: Mapping[str, Any]) -> CheckedModel:
        """From a row of the result.

        Raises:
            KeyError: A field is missing.
            TypeError: A field has the wrong type.
        """
        attack = row["attack"]
        return cls(
            row["name"],
            attack["name"] if attack else "",
            row["drives"],
            row["frames"],
            row["objects"],
            row["found"],
            row["ghosts"],
            tuple(
                RangeCheck(**{name: each[name] for name in RangeCheck.__dataclass_fields__})
                for each in row["check"]
            ),
        )
