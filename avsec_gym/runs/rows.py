"""A cell's result as rows of the run's tables.

The table ``drives`` keeps the name of its first version and holds episodes.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from avsec_gym.runs.experiment import CellResult
from avsec_gym.runs.stored_boxes import boxes_to_text

Rows = dict[str, list[dict[str, Any]]]
"""Rows by table, column by column, without the cell's id."""


def rows_of(result: CellResult) -> Rows:
    """The rows; numbers of NumPy become Python's."""
    return {
        "drives": [
            {**_place(row), "planner": row.planner, **_plain(row.record.to_json())}
            for row in result.episodes
        ],
        "detections": [
            {**_place(row), "scenario": row.scenario, "boxes": boxes_to_text(row.boxes)}
            for row in result.detections
        ],
        "measurements": [
            {**_place(row), "scenario": row.scenario, "name": row.name, "value": float(row.value)}
            for row in result.measurements
        ],
        "timings": [
            {"part": part, "seconds": float(seconds)} for part, seconds in result.seconds.items()
        ],
    }


def _place(row: Any) -> dict[str, Any]:
    return {"setting": row.setting, "strength": float(row.strength)}


def _plain(values: dict[str, Any]) -> dict[str, Any]:
    return {
        name: value.item() if isinstance(value, np.generic) else value
        for name, value in values.items()
    }
