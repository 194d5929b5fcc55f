"""Rows of the run's tables as results again: the way back of `avsec_gym.runs.rows`."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

from avsec_gym.runs.experiment import EpisodeRow, Measurement

if TYPE_CHECKING:
    import sqlite3

MEASURED = "setting, scenario, name, value, strength"
"""The columns that `measurements_from` takes."""


@dataclass(frozen=True, slots=True)
class FinishedCell:
    """A cell that is done or has failed.

    Args:
        id: The id of the cell.
        work: The place of its work.
        arguments: What its work was called with.
        status: ``done`` or ``failed``.
        error: Why it failed; None: it did not.
        seconds: How long it took.
        finished: When, in ISO 8601, UTC.
    """

    id: str
    work: str
    arguments: Mapping[str, Any]
    status: str
    error: str | None
    seconds: float
    finished: str

    @property
    def failed(self) -> bool:
        """Whether it failed."""
        return self.status == "failed"


def measurements_from(
    rows: Iterable[tuple[str, str, str, float | None, float]],
) -> list[Measurement]:
    """Rows of the columns `MEASURED`; NULL becomes NaN again."""
    return [
        Measurement(setting, scenario, name, math.nan if value is None else value, strength)
        for setting, scenario, name, value, strength in rows
    ]


def episodes_from(rows: Iterable[sqlite3.Row]) -> list[EpisodeRow]:
    """Rows of the table ``drives``; NULL becomes NaN again where a number was.

    Folders of earlier releases lack the columns of `avsec_gym.runs.schema.ADDED`: nothing was
    stored there.
    """
    from avsec_gym.metrics.safety import SafetyRecord

    missing = {
        column.name: math.nan if column.type == "float" else None for column in fields(SafetyRecord)
    }
    found = []
    for row in rows:
        stored = dict(row)
        values: dict[str, Any] = {
            name: nothing if stored.get(name) is None else stored[name]
            for name, nothing in missing.items()
        }
        if values["swept_collision"] is not None:
            values["swept_collision"] = bool(values["swept_collision"])
        record = SafetyRecord(**values)
        found.append(EpisodeRow(stored["setting"], record, stored["strength"], stored["planner"]))
    return found
