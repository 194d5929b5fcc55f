"""Shares of clean and attacked moments, side by side (figures 3.5, 3.7 and 3.9 of the thesis)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from avsec_gym.report.plots import Frame, Scale, drawing, polyline, text
from avsec_gym.report.tables_of_validation import MEASURE_WORDS

_WIDTH, _HEIGHT = 330, 220


def draw_distributions(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """A drawing of each scenario and share.

    Args:
        rows: Of `avsec_gym.experiments.chapter3.summary.distributions`.
    """
    return [_draw(row) for row in rows]


def _draw(row: Mapping[str, Any]) -> str:
    highest = 100 * max(*row["clean"], *row["attacked"])
    frame = Frame(
        Scale(0, 100 * row["largest"], 40, 322), Scale(0, max(highest, 1.0), _HEIGHT - 36, 26)
    )
    words = f"{row['scenario']}: {MEASURE_WORDS[row['measure']]}"
    parts = [
        frame.axes(frame.x.ticks(4), frame.y.ticks(4)),
        text((frame.x.start, 14), words, "name"),
        text(((frame.x.start + frame.x.end) / 2, _HEIGHT - 4), "%", "middle"),
    ]
    for kind, which in (("line-0", "clean"), ("line-1", "attacked")):
        parts.append(polyline(_steps(frame, row[which], 100 * row["largest"]), kind))
    label = f"{words}, share of clean and of attacked moments, in percent"
    return drawing(_WIDTH, _HEIGHT, parts, label)


def _steps(frame: Frame, shares: Sequence[float], largest: float) -> list[tuple[float, float]]:
    points = []
    for number, share in enumerate(shares):
        for edge in (number, number + 1):
            points.append(frame.at((edge * largest / len(shares), 100 * share)))
    return points
