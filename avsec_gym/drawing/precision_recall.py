"""Precision over recall, a panel for each class and metric, a curve for each difficulty."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from avsec_gym.drawing.figure_style import FAINT, FIGURE_STYLE, INK, as_drawn
from avsec_gym.metrics.average_precision import METRICS, AveragePrecision
from avsec_gym.metrics.average_precision_frames import LEVELS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLOURS = ("#56B4E9", "#0072B2", "#D55E00")
_PANEL, _ABOVE, _BELOW = 2.0, 0.85, 1.4
"""Inches: a panel's height, what stands above the first, and below each (axis and figures)."""
_TITLES = {"2d": "in the image", "bev": "from above", "3d": "in space", "aos": "orientation"}


def draw_precision_recall(result: AveragePrecision, *, title: str = "") -> Figure:
    """A row for each class of which something was found; the others are named in the title.

    Args:
        result: The measured average precision.
        title: Title above the picture.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    best = np.nan_to_num(result.precision).max(axis=(1, 2, 3)).tolist()
    rows = [c for c, precision in enumerate(best) if precision > 0]
    lost = [name for c, name in enumerate(result.classes) if c not in rows]
    if lost:
        title = f"{title}\nnothing found of {', '.join(lost)}".strip()
    height = (_PANEL + _BELOW) * max(len(rows), 1) + _ABOVE
    with mpl.rc_context(FIGURE_STYLE):
        figure = Figure(figsize=(12.5, height), dpi=110, facecolor="white")
        figure.text(0.05, 1 - 0.15 / height, as_drawn(title), ha="left", va="top", fontsize=10)
        if not rows:
            return figure
        panels = figure.subplots(
            len(rows), len(METRICS), sharex=True, sharey=True, squeeze=False,
            gridspec_kw={
                "left": 0.05, "right": 0.985, "bottom": _BELOW / height, "top": 1 - _ABOVE / height,
                "hspace": _BELOW / _PANEL, "wspace": 0.1,
            },
        )  # fmt: skip
        for axes_row, c in zip(panels, rows, strict=True):
            for m, axes in enumerate(axes_row):
                _draw_panel(axes, result, c, m)
            axes_row[0].set_ylabel("precision")
        for axes in panels[-1]:
            axes.set_xlabel("recall")
    return figure


def _draw_panel(axes: Axes, result: AveragePrecision, c: int, m: int) -> None:
    axes.spines[["top", "right"]].set_visible(False)
    axes.set_title(
        f"{result.classes[c]} {_TITLES[METRICS[m]]}, IoU > {result.min_iou[c, m]:g}",
        loc="left",
        fontsize=9,
        color=INK,
    )
    recall = np.linspace(0, 1, result.precision.shape[-1])
    for level, name in enumerate(LEVELS):
        curve = result.precision[c, m, level]
        if result.labels[c, level] and not np.isnan(curve).any():
            figures = f"{result.ap11[c, m, level]:.1f} | {result.ap40[c, m, level]:.1f}"
            axes.plot(
                recall, curve, color=_COLOURS[level], lw=1.6, clip_on=False,
                label=f"{name} {figures}",
            )  # fmt: skip
    axes.set_xlim(0, 1)
    axes.set_ylim(0, 1)
    axes.set_xticks([0, 0.25, 0.5, 0.75, 1], ["0", "0.25", "0.5", "0.75", "1"])
    if axes.lines:
        # Below the panel: inside, a long entry always lies on some curve.
        axes.legend(
            title="AP11 | AP40, %", frameon=False, fontsize=8, title_fontsize=8,
            loc="upper left", bbox_to_anchor=(0.0, -0.55 / _PANEL), borderaxespad=0, borderpad=0,
        )  # fmt: skip
    else:
        axes.text(0.5, 0.5, "alpha unknown", ha="center", color=FAINT)
