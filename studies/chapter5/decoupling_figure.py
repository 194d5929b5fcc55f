"""The picture of the central question: precision that attacks take, and safety that they take.

    python -m studies.chapter5.decoupling_figure REPORT.json ERRORS.json --figure FILE

REPORT.json is what ``avsec report RUN --json`` prints, ERRORS.json what `costly_errors` does.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from avsec_gym.drawing.figure_style import FAINT, FIGURE_STYLE
from avsec_gym.experiments.chapter5.attack_names import attack_name, detector_name
from avsec_gym.experiments.chapter5.decoupling import UnattackedRow
from avsec_gym.experiments.chapter5.losses import LossRow
from avsec_gym.experiments.chapter5.settings import JOINT_PATCHES, NOISES, PATCHES, PERTURBATIONS
from avsec_gym.experiments.json_rows import row_of
from avsec_gym.geometry import Floats
from avsec_gym.metrics.estimate import Estimate
from avsec_gym.storage.json_files import read_json_object
from studies.chapter5.headroom import NOTHING, HeadroomRow

_MARKS = {
    PERTURBATIONS[0]: ("o", "#3d9be0"),
    PERTURBATIONS[1]: ("o", "#0b5ea8"),
    PATCHES[0]: ("s", "#e08a00"),
    PATCHES[1]: ("s", "#c4400f"),
    JOINT_PATCHES[0]: ("D", "#c06aa8"),
    JOINT_PATCHES[1]: ("D", "#84307a"),
    NOISES[1]: ("P", "#8793a0"),
}
"""Marker and colour of what is drawn."""


def draw_decoupling(
    unattacked: Sequence[UnattackedRow],
    attacks: Sequence[LossRow],
    headroom: Sequence[HeadroomRow],
    path: str | Path,
) -> None:
    """A panel for each detector; dashed: what a car loses that sees nothing at all.

    Args:
        unattacked: A row for each detector.
        attacks: A row for each condition.
        headroom: Rows of cars without a detector.
        path: The picture's file.
    """
    (blind,) = (100 * row.rates.safe_driving_rate for row in headroom if row.seen == NOTHING)
    with matplotlib.rc_context(FIGURE_STYLE):
        figure = Figure(figsize=(8.6, 3.7), facecolor="white")
        count = len(unattacked)
        panels = figure.subplots(1, count, sharex=True, sharey=True, squeeze=False)[0]
        for axes, clean in zip(panels, unattacked, strict=True):
            assert clean.safety.value is not None
            own = [row for row in attacks if row.condition.detector == clean.detector]
            _draw_attacks(axes, [row for row in own if not row.condition.whole_levels])
            axes.axhline(clean.safety.value - blind, color=FAINT, linestyle="--", linewidth=1)
            axes.annotate(
                "a car that sees nothing",
                (1, clean.safety.value - blind),
                (-4, 3),
                xycoords=("axes fraction", "data"),
                textcoords="offset points",
                ha="right",
                fontsize=8,
                color=FAINT,
            )
            axes.set_title(detector_name(clean.detector), loc="left", weight="bold")
            axes.set_xlabel("average precision taken, points")
        panels[0].set_ylabel("safe driving taken, points")
        handles, names = panels[0].get_legend_handles_labels()
        figure.legend(handles, names, loc="lower center", ncol=4, frameon=False, fontsize=8)
        figure.subplots_adjust(0.07, 0.27, 0.99, 0.92, wspace=0.06)
        figure.savefig(path, dpi=150)


def _draw_attacks(axes: Axes, rows: Sequence[LossRow]) -> None:
    axes.axhline(0, color=FAINT, linewidth=0.8)
    axes.axvline(0, color=FAINT, linewidth=0.8)
    for attack, (marker, colour) in _MARKS.items():
        own = [row for row in rows if row.condition.attack == attack]
        if not own:
            continue
        (x, across), (y, upward) = (
            _points(losses)
            for losses in ([row.precision_lost for row in own], [row.safety_lost for row in own])
        )
        axes.errorbar(x, y, upward, across, fmt="none", ecolor=colour, elinewidth=0.7, alpha=0.35)
        strength = 0.0 if attack in PERTURBATIONS else own[0].condition.strength
        name = attack_name(attack, strength)
        axes.plot(
            x, y, marker, color=colour, markersize=5, label=name, linestyle="-", linewidth=0.8
        )


def _points(losses: Sequence[Estimate]) -> tuple[Floats, Floats]:
    """What is lost, and how far the interval reaches below and above."""
    lost, low, high = np.transpose([[loss.value, *(loss.interval or ())] for loss in losses])
    return lost, np.array([lost - low, high - lost])


def main(arguments: Sequence[str] | None = None) -> int:
    """Draw; returns the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("report", type=Path, help="JSON of `avsec report RUN --json`")
    parser.add_argument("errors", type=Path, help="JSON of `costly_errors`")
    parser.add_argument("--figure", type=Path, required=True, help="the picture's file")
    options = parser.parse_args(arguments)
    report, errors = (
        read_json_object(path, remedy="Make it anew.") for path in (options.report, options.errors)
    )
    draw_decoupling(
        [row_of(UnattackedRow, row) for row in report["decoupling"]["unattacked"]],
        [row_of(LossRow, row) for row in report["decoupling"]["attacks"]],
        [row_of(HeadroomRow, row) for row in errors["headroom"]],
        options.figure,
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
