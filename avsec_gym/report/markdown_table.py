"""Tables and figures of result pages in Markdown."""

from __future__ import annotations

import math
from collections.abc import Sequence

UNKNOWN = "–"


def markdown_table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Lines of a table.

    Example:
        >>> markdown_table(["a", "b"], [["1", "2"]])
        ['| a | b |', '| --- | --- |', '| 1 | 2 |']
    """
    lines = [list(columns), ["---"] * len(columns), *rows]
    return ["| " + " | ".join(line) + " |" for line in lines]


def number(value: float | None, digits: int) -> str:
    """A number with so many digits behind the point; a dash for None and NaN.

    Example:
        >>> number(1234.567, 1), number(-0.001, 2), number(None, 1)
        ('1,234.6', '0.00', '–')
    """
    if value is None or math.isnan(value):
        return UNKNOWN
    return f"{round(value, digits) + 0.0:,.{digits}f}"


def share(value: float | None) -> str:
    """A share of 1 in percent.

    Example:
        >>> share(0.5)
        '50.0'
    """
    return number(None if value is None else 100 * value, 1)


def interval(value: float | None, bounds: Sequence[float | None] | None, digits: int = 1) -> str:
    """A value and its interval, where it has one.

    Example:
        >>> interval(5.0, (4.0, 6.5))
        '5.0 (4.0 to 6.5)'
    """
    if value is None or bounds is None:
        return number(value, digits)
    low, high = (number(bound, digits) for bound in bounds)
    return f"{number(value, digits)} ({low} to {high})"
