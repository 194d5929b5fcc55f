"""Tables of the run itself: how long it took, and rates that no experiment reports."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from avsec_gym.drawing.page_table import Table, TableCell, figure, name, number
from avsec_gym.report.run_facts import CellTimes, OtherRates


def time_table(attacks: Mapping[str, CellTimes], attack_names: Mapping[str, str]) -> Table:
    """Where the time goes, by attack.

    Args:
        attacks: Times by attack.
        attack_names: What attacks are called; others are called as in the cells.
    """
    lines = [
        [
            name(attack_names.get(attack, attack)),
            _count(times.cells),
            figure(times.seconds / max(times.cells, 1), digits=2),
            figure(times.seconds / 60, digits=1),
        ]
        for attack, times in attacks.items()
    ]
    return Table(
        "Time by attack",
        ["attack", "cells", "seconds each", "minutes in all"],
        lines,
        "A cell is one scene, detector and attack with all its strengths and intentions.",
    )


def other_table(rows: Sequence[OtherRates]) -> Table:
    """Rates under settings that no experiment reports."""
    rates = ("success_rate", "collision_rate", "safe_driving_rate")
    lines = []
    for row in rows:
        columns = row.rates.to_json()
        lines.append(
            [
                name(row.setting),
                figure(row.strength, digits=1),
                _count(row.rates.scenarios),
                *(figure(columns[rate], columns[f"{rate}_interval"], scale=100) for rate in rates),
            ]
        )
    return Table(
        "Other settings, %",
        ["setting", "strength", "episodes", "success", "collision", "safe driving"],
        lines,
        "In brackets: 95 % intervals, Wilson’s, widened by what the episodes of one scene share.",
    )


def _count(value: int) -> TableCell:
    return TableCell(number(value, digits=0), key=value)
