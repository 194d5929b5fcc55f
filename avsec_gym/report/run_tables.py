"""Tables of the run itself: how long it took, and rates that no experiment reports."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from avsec_gym.drawing.page_table import Table, TableCell, figure, name, number

Rows = Sequence[Mapping[str, Any]]


def time_table(data: Mapping[str, Any], attack_names: Mapping[str, str]) -> Table:
    """Where the time goes, by attack.

    Args:
        data: The report's figures.
        attack_names: What attacks are called; others are called as in the cells.
    """
    lines = [
        [
            name(attack_names.get(attack, attack)),
            _count(row["cells"]),
            figure(row["seconds"] / max(row["cells"], 1), digits=2),
            figure(row["seconds"] / 60, digits=1),
        ]
        for attack, row in data["timings"]["attacks"].items()
    ]
    return Table(
        "Time by attack",
        ["attack", "cells", "seconds each", "minutes in all"],
        lines,
        "A cell is one scene, detector and attack with all its strengths and intentions.",
    )


def other_table(rows: Rows) -> Table:
    """Rates under settings that no experiment reports."""
    rates = ("success_rate", "collision_rate", "safe_driving_rate")
    lines = [
        [
            name(row["setting"]),
            figure(row["strength"], digits=1),
            _count(row["scenarios"]),
            *(figure(row[rate], row[f"{rate}_interval"], scale=100) for rate in rates),
        ]
        for row in rows
    ]
    return Table(
        "Other settings, %",
        ["setting", "strength", "drives", "success", "collision", "safe driving"],
        lines,
        "In brackets: 95 % Wilson intervals.",
    )


def _count(value: int) -> TableCell:
    return TableCell(number(value, digits=0), key=value)
