"""Cells that many tables of chapter 5 have: a detector under its attack, and counts."""

from __future__ import annotations

from avsec_gym.drawing.page_table import UNKNOWN, TableCell, name, number
from avsec_gym.experiments.chapter5.attack_names import attack_name, detector_name
from avsec_gym.experiments.chapter5.outcomes import Condition


def condition_names(condition: Condition) -> list[TableCell]:
    """The names of a detector and of the attack that it is under."""
    attack = attack_name(condition.attack, condition.strength, condition.whole_levels)
    return [name(detector_name(condition.detector)), name(attack)]


def count_cell(value: int | None) -> TableCell:
    """A whole number; a dash where there is none."""
    return TableCell(UNKNOWN) if value is None else TableCell(number(value, digits=0), key=value)
