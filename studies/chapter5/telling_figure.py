"""The picture of which measure predicts safety: over attacks, and over single episodes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from avsec_gym.drawing.figure_style import FAINT, FIGURE_STYLE
from avsec_gym.experiments.chapter5.attack_names import detector_name
from studies.chapter5.telling_flips import FlipRow
from studies.chapter5.telling_measures import ALL_ATTACKS, BOTH, MEASURES, MeasureRow

TellingRow = MeasureRow | FlipRow
_COLOURS = ("#0b5ea8", "#e08a00", "#5b6673")
_MARKS = ("o", "s", "D")


def draw_telling(
    measures: Sequence[MeasureRow], flips: Sequence[FlipRow], path: str | Path
) -> None:
    """A line for each measure, a mark for each detector and for both together, all attacks.

    Args:
        measures: Rows of `telling_rows`.
        flips: Rows of `flip_rows`.
        path: The picture's file.
    """
    with matplotlib.rc_context(FIGURE_STYLE):
        figure = Figure(figsize=(8.6, 4.6), facecolor="white")
        left, right = figure.subplots(1, 2, sharey=True)
        _draw(left, [(row, row.rho) for row in measures], 0.0, (-1.05, 1.05))
        _draw(right, [(row, row.area) for row in flips], 0.5, (0.25, 1.02))
        left.set_title("over attacks", loc="left", weight="bold")
        right.set_title("in single drives of an attack", loc="left", weight="bold")
        left.set_xlabel("rank correlation with safe driving lost")
        right.set_xlabel("area under the ROC curve")
        left.set_yticks(range(len(MEASURES)), MEASURES)
        left.set_ylim(len(MEASURES) - 0.4, -0.6)
        handles, names = left.get_legend_handles_labels()
        figure.legend(handles, names, loc="lower center", ncol=3, frameon=False, fontsize=8)
        figure.subplots_adjust(0.23, 0.2, 0.99, 0.93, wspace=0.06)
        figure.savefig(path, dpi=150)


def _draw(
    axes: Axes,
    rows: Sequence[tuple[TellingRow, float | None]],
    nothing: float,
    limits: tuple[float, float],
) -> None:
    axes.axvline(nothing, color=FAINT, linewidth=0.8)
    detectors = list(dict.fromkeys(row.detector for row, _ in rows))
    for number, detector in enumerate(detectors):
        own = {
            row.measure: (value, row.interval or [np.nan] * 2)
            for row, value in rows
            if row.detector == detector and row.family == ALL_ATTACKS and value is not None
        }
        lines = [line for line, measure in enumerate(MEASURES) if measure in own]
        found = [own[MEASURES[line]] for line in lines]
        values = np.array([value for value, _ in found])
        bounds = np.array([interval for _, interval in found]).reshape(-1, 2)
        at = np.array(lines) + 0.22 * (number - (len(detectors) - 1) / 2)
        spread = np.abs(bounds.T - values)
        colour, mark = _COLOURS[number % 3], _MARKS[number % 3]
        label = "both together" if detector == BOTH else detector_name(detector)
        axes.errorbar(values, at, None, spread, fmt="none", ecolor=colour, elinewidth=1, alpha=0.5)
        axes.plot(values, at, mark, color=colour, markersize=5, linestyle="none", label=label)
    axes.set_xlim(*limits)
