"""The picture of what ghosts cost: safe driving over their distance."""

from __future__ import annotations

from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from avsec_gym.drawing.figure_style import FAINT, FIGURE_STYLE
from avsec_gym.experiments.thesis import SAFETY
from avsec_gym.scenario.intention import Intention
from studies.chapter5.ghost_ceiling import (
    BINS,
    COUNTS,
    WIDTHS,
    GhostCeilings,
    kind_in_words,
    safe_interval,
)

_COLOURS = dict(zip(WIDTHS, ("#5b6673", "#e08a00", "#0b5ea8"), strict=True))
_STYLES = dict(zip(COUNTS, (("-", "o"), ("--", "s")), strict=True))


def draw_ceilings(result: GhostCeilings, path: str | Path) -> None:
    """A panel for each intention: safe driving over the distance, a line for each kind of ghosts.

    Args:
        result: The result of `ghost_ceiling`.
        path: The picture's file.
    """
    with matplotlib.rc_context(FIGURE_STYLE):
        figure = Figure(figsize=(8.6, 3.6), facecolor="white")
        panels = figure.subplots(1, len(Intention), sharey=True)
        for axes, intention in zip(panels, Intention, strict=True):
            _panel(axes, result, intention)
        panels[0].set_ylabel("safe driving, %")
        panels[1].set_xlabel("distance to the ghost’s rear, m")
        handles, names = panels[0].get_legend_handles_labels()
        figure.legend(handles, names, loc="lower center", ncol=4, frameon=False, fontsize=8)
        figure.subplots_adjust(0.065, 0.29, 0.99, 0.92, wspace=0.1)
        figure.savefig(path, dpi=150)


def _panel(axes: Axes, result: GhostCeilings, intention: Intention) -> None:
    for count in COUNTS:
        for width in WIDTHS:
            rows = [row for row in result.of(intention, count, width) if row.distances in BINS]
            at = [(row.nearest + row.farthest) / 2 for row in rows]
            values = np.array([100 * row.rates.safe_driving_rate for row in rows])
            bounds = 100 * np.array([safe_interval(row.rates) for row in rows])
            style, mark = _STYLES[count]
            axes.errorbar(
                at,
                values,
                np.abs(bounds.T - values),
                color=_COLOURS[width],
                linestyle=style,
                marker=mark,
                markersize=4,
                linewidth=1.2,
                elinewidth=0.8,
                label=kind_in_words(count, width),
            )
    alone = result.alone(intention)
    axes.axhline(100 * alone.safe_driving_rate, color=FAINT, linewidth=0.8, label="no ghost")
    thesis = SAFETY["stereo_rcnn", "patch-specific", intention].safe
    axes.axhline(
        100 * thesis, color=FAINT, linewidth=0.8, linestyle=":", label="thesis, specific patch"
    )
    axes.set_title(str(intention), loc="left", weight="bold")
    axes.set_ylim(0, 100)
    axes.set_xticks([BINS[0][0], *(farthest for _, farthest in BINS)])
