"""A picture of what sensors detect and name, from the JSON of a report, the thesis beside it.

Run ``python -m studies.chapter3.identification_figure REPORT.json --out FILE``, where
``avsec report RUN --json`` wrote the report of `identification`.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import PercentFormatter

from avsec_gym.drawing.figure_style import FAINT, FIGURE_STYLE
from avsec_gym.drawing.scenario_picture import save_picture
from avsec_gym.errors import DataError
from avsec_gym.experiments.chapter3.identification.calibration import LikelihoodCalibration
from avsec_gym.experiments.chapter3.identification.detection_rates import (
    CaseRates,
    DetectionRateRow,
)
from avsec_gym.experiments.chapter3.identification.error_distributions import CaseDistribution
from avsec_gym.experiments.chapter3.identification.identification_rates import (
    IdentificationRates,
    MethodRates,
)
from avsec_gym.experiments.chapter3.identification.summary import ValidationSummary
from avsec_gym.experiments.chapter3.thesis import DETECTION, IDENTIFICATION
from avsec_gym.experiments.json_rows import row_of
from avsec_gym.storage.json_files import read_json
from studies.answer import exit_code

_OURS, _BLUE, _THESIS = "#D7263D", "#1F77B4", "#222222"
_HIGHEST_RATE = 0.1
_METHODS = {
    "maximum likelihood": ("maximum likelihood", _OURS, "-"),
    "algorithm 2, any": ("algorithm 2, all four shares", _BLUE, "-"),
    "algorithm 2, error": ("algorithm 2, E alone", _BLUE, ":"),
}


def draw_identification(summary: ValidationSummary) -> Figure:
    """E clean and attacked, detection and identification over r, and what probabilities are worth.

    Args:
        summary: The results of a run.
    """
    import matplotlib as mpl

    with mpl.rc_context(FIGURE_STYLE):
        figure = Figure(figsize=(9.2, 9.0), dpi=110, facecolor="white", layout="constrained")
        panels = figure.subplots(3, 2)
        for axes, row in zip(panels[0], summary.case_distributions, strict=True):
            _distribution(axes, row)
        for axes, row in zip(panels[1], summary.case_distributions, strict=True):
            _detection(axes, row.scenario, summary.detection)
        _identification(panels[2, 0], summary.identification)
        _reliability(panels[2, 1], summary.calibration)
    return figure


def _distribution(axes: Axes, row: CaseDistribution) -> None:
    """Figures 3.5 and 3.7, all seven cases as one."""
    edges = np.linspace(0.0, row.largest, len(row.clean) + 1)
    attacked = np.mean([*row.cases.values()], axis=0)
    for shares, colour, label in ((row.clean, _BLUE, "clean"), (attacked, _OURS, "attacked")):
        axes.stairs(shares, edges, color=colour, fill=True, alpha=0.3)
        axes.stairs(shares, edges, color=colour, label=label)
    for bound, label in zip(row.beside.bounds, ("thesis' bounds", ""), strict=True):
        axes.axvline(bound, color=_THESIS, lw=0.8, ls="--", label=label)
    _finish(axes, f"disparity error E of {row.scenario}", "E", "share of frames")
    axes.set(xlim=(0, row.largest), ylim=(0, None))


def _detection(axes: Axes, scenario: str, rows: Sequence[DetectionRateRow]) -> None:
    """Figures 3.6 and 3.8, the mean of all seven cases."""
    for criterion, label, line in (("any", "all four shares", "-"), ("error", "E alone", ":")):
        own = [row for row in rows if (row.scenario, row.criterion) == (scenario, criterion)]
        _curve(axes, [(row.rate, row.rates) for row in own], label, _OURS, line)
    thesis = {rate: share for (name, rate), share in DETECTION.items() if name == scenario}
    axes.plot([*thesis], [*thesis.values()], "o", mfc="none", color=_THESIS, label="thesis")
    _finish(axes, f"attacks detected by {scenario}", "r", "")
    axes.set(xlim=(-0.003, _HIGHEST_RATE), ylim=(0, 1.03))


def _identification(axes: Axes, rows: Sequence[MethodRates]) -> None:
    """Figure 3.10, the mean of all sensors."""
    for method, (label, colour, line) in _METHODS.items():
        own = [row.rates for row in rows if row.method == method]
        _curve(axes, [(rates.rate, rates) for rates in own], label, colour, line)
    thesis = [mean for *_, mean in IDENTIFICATION.values()]
    axes.plot([*IDENTIFICATION], thesis, "o", mfc="none", color=_THESIS, label="thesis")
    _finish(axes, "the attacked one of four sensors named", "r", "")
    axes.set(xlim=(-0.003, _HIGHEST_RATE), ylim=(0, 1.03))


def _reliability(axes: Axes, calibration: LikelihoodCalibration) -> None:
    axes.plot([0, 1], [0, 1], color=FAINT, lw=0.8)
    for prior, label, colour, marker in (
        (calibration.probabilities, "the prior as it comes", _OURS, "o"),
        (calibration.all_alike, "all states alike", _BLUE, "s"),
    ):
        predicted = [row.predicted for row in prior.reliability]
        observed = [row.observed for row in prior.reliability]
        spread = np.abs(np.array([row.interval for row in prior.reliability]).T - observed)
        axes.errorbar(
            predicted, observed, spread, fmt=marker, ms=4, lw=0.8, color=colour, label=label
        )
    _finish(axes, "sensors attacked, by the predicted probability", "P(attacked)", "")
    axes.set(xlim=(-0.02, 1.02), ylim=(-0.02, 1.02))


def _curve(
    axes: Axes,
    points: Sequence[tuple[float, CaseRates | IdentificationRates]],
    label: str,
    colour: str,
    line: str,
) -> None:
    """Averages with their intervals, over r."""
    rates = [rate for rate, _ in points]
    shares = np.array([found.average for _, found in points], dtype=float)
    low, high = np.array([found.interval for _, found in points], dtype=float).T
    axes.fill_between(rates, low, high, color=colour, alpha=0.2, lw=0)
    axes.plot(rates, shares, line, color=colour, label=label)


def _finish(axes: Axes, title: str, below: str, beside: str) -> None:
    axes.set_title(title, loc="left")
    axes.set(xlabel=below, ylabel=beside)
    axes.xaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    axes.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, fontsize=8)


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("report", type=Path, help="of identification, as JSON")
    parser.add_argument("--out", type=Path, default=Path("identification.png"))
    options = parser.parse_args(arguments)

    def work() -> None:
        figure = _figure(options.report)
        save_picture(figure, options.out, overwrite=True)

    return exit_code(work)


_AGAIN = "Write one by `avsec report RUN --json`, of a run of identification."


def _figure(path: Path) -> Figure:
    try:
        return draw_identification(
            row_of(ValidationSummary, read_json(path, remedy=_AGAIN)["validation"])
        )
    except (ValueError, KeyError, TypeError) as error:
        raise DataError(
            "This is no report of what sensors detect, or one of an earlier version.",
            path=path,
            remedy=_AGAIN,
        ) from error


if __name__ == "__main__":
    sys.exit(main())
