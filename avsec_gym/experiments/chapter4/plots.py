"""Figures 4a and 4b of the thesis, ROC curves, and what errors and vehicles change."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from avsec_gym.drawing.page_figure import Figure, line_key, mark_key
from avsec_gym.drawing.page_table import bounds, number
from avsec_gym.experiments.chapter4.detection_rates import PAIRS, REGIONS, DetectionRate
from avsec_gym.experiments.chapter4.distance_distributions import LARGEST
from avsec_gym.experiments.chapter4.panels import Mark, lines_panel, steps_panel
from avsec_gym.experiments.chapter4.settings import (
    ATTACKS,
    CLEAN,
    CONDITIONS,
    EXACT,
    METHODS,
    OPERATING_RATE,
    USUAL,
    ConnectedCondition,
)
from avsec_gym.experiments.chapter4.shown_figures import IN_WORDS
from avsec_gym.experiments.chapter4.summary import ConnectedSummary
from avsec_gym.experiments.chapter4.thesis import DETECTION, DISTANCE_BOUND
from avsec_gym.validation.connected.result import AttackKind

_KINDS = {"surfaces": "line-0", "rays": "line-1", "learned": "line-2"}
_SHARE_OF = {"surfaces": PAIRS, "rays": REGIONS, "learned": REGIONS}
"""What r is a share of in figure 4b."""
_MOST_FALSE = 0.2
"""False positive rate up to which ROC curves are drawn."""
_METHODS = [line_key(_KINDS[method], IN_WORDS[method]) for method in METHODS]


def figures_of_connected(summary: ConnectedSummary) -> list[Figure]:
    """All of a run, of the conditions that it has.

    Args:
        summary: The results of the run.
    """
    shown = [each for each in (EXACT, USUAL) if each.name in summary.instants]
    factors = _factor_figure(summary)
    figures = [
        _distance_figure(summary, shown),
        _detection_figure(summary, shown),
        _roc_figure(summary, shown),
    ]
    return [figure for figure in [*figures, factors] if figure.drawings]


def _distance_figure(summary: ConnectedSummary, conditions: Sequence[ConnectedCondition]) -> Figure:
    rows = {row.condition: row for row in summary.distances}
    panels = [
        steps_panel(
            f"{kind}, {_short(condition)}",
            "distance, m",
            LARGEST,
            {
                "line-0": rows[condition.name].bins[CLEAN],
                "line-1": rows[condition.name].bins[kind],
            },
            DISTANCE_BOUND,
        )
        for condition in conditions
        for kind in ATTACKS
    ]
    return Figure(
        "Figure 4a: distances of surfaces (equation 4.1), share in %",
        panels,
        [line_key("line-0", "attack-free"), line_key("line-1", "of the victim, attacked")],
        note=f"Three vehicles. The last bin holds all beyond {LARGEST:g} m. Dashed: the thesis"
        f" finds most attack-free distances below {DISTANCE_BOUND:g} m, and most attacked ones"
        f" above. Pairs of surfaces that have a distance: {_compared(summary, conditions)}; of the"
        " others a vehicle has too few points in the region.",
        columns=4,
    )


def _compared(summary: ConnectedSummary, conditions: Sequence[ConnectedCondition]) -> str:
    """How many pairs of surfaces were compared, of how many, in each panel and attack-free."""
    rows = {row.condition: row for row in summary.distances}
    return "; ".join(
        f"{_short(condition)}: "
        + ", ".join(
            f"{state} {share.count} of {share.of}"
            for state, share in rows[condition.name].compared.items()
        )
        for condition in conditions
    )


def _detection_figure(
    summary: ConnectedSummary, conditions: Sequence[ConnectedCondition]
) -> Figure:
    panels = []
    for condition in conditions:
        for kind in ATTACKS:
            lines = {
                _KINDS[method]: [
                    (100 * row.rate, row.detected.percent)
                    for row in summary.detection
                    if (row.condition, row.kind) == (condition.name, kind)
                    and (row.method, row.of) == (method, _SHARE_OF[method])
                    and row.detected.of
                ]
                for method in METHODS
            }
            marks = [
                Mark(
                    (100 * rate, 100 * share),
                    "hollow small theirs line-0",
                    f"The thesis, r = {rate:g}: {number(share, 100, 0)} %",
                )
                for rate, share in DETECTION.items()
                if kind == "ghost"
            ]
            panels.append(lines_panel(f"{kind}, {_short(condition)}", "r, %", 100, lines, marks))
    return Figure(
        "Figure 4b: detection rate over r, %",
        panels,
        _METHODS,
        note="Three vehicles. Of decidable attacks, at thresholds of other places. r is a share of"
        " distances of pairs of surfaces, as in the thesis, and of regions for the others. Where"
        " surfaces compare nothing, an attack is a miss at any r. Hollow: the thesis.",
        columns=4,
    )


def _roc_figure(summary: ConnectedSummary, conditions: Sequence[ConnectedCondition]) -> Figure:
    panels = []
    for condition in conditions:
        for kind in ATTACKS:
            lines = {
                _KINDS[row.method]: [(100 * false, 100 * true) for false, true in row.curve]
                for row in summary.roc
                if (row.condition, row.kind) == (condition.name, kind)
            }
            title = f"{kind}, {_short(condition)}"
            panels.append(lines_panel(title, "false positives, %", 100 * _MOST_FALSE, lines))
    return Figure(
        "ROC over decidable regions: true positives, %",
        panels,
        _METHODS,
        note=f"Three vehicles. False positive rates up to {100 * _MOST_FALSE:g} % are drawn.",
        columns=4,
    )


def _factor_figure(summary: ConnectedSummary) -> Figure:
    """Detection at r = 3 % over the errors of poses, and over the number of vehicles."""
    panels = []
    for kind in ATTACKS:
        by_noise = _marks(summary, kind, _of_noise)
        by_vehicles = _marks(summary, kind, _of_vehicles)
        panels.append(lines_panel(f"{kind}, clocks alike", "errors, m and deg", 0.6, {}, by_noise))
        panels.append(lines_panel(f"{kind}, {_short(USUAL)}", "vehicles", 7, {}, by_vehicles))
    has_some = any("<circle" in panel for panel in panels)
    return Figure(
        f"Detection at thresholds of other places for r = {100 * OPERATING_RATE:g} %, %",
        panels if has_some else (),
        [mark_key(_KINDS[method], IN_WORDS[method]) for method in METHODS],
        note="Of decidable attacks. Whiskers: 95 % intervals that know of instants, for a given"
        " threshold. Left: errors of poses, three vehicles, clocks alike. Right: the number of"
        " vehicles.",
        columns=4,
    )


def _marks(
    summary: ConnectedSummary, kind: AttackKind, place: Callable[[ConnectedCondition], float | None]
) -> list[Mark]:
    """The detection rates of conditions that have a place on the axis."""
    rows = {
        (row.condition, row.method): row
        for row in summary.detection
        if (row.kind, row.of, row.rate) == (kind, REGIONS, OPERATING_RATE)
    }
    marks = []
    for condition in CONDITIONS:
        x = place(condition)
        for method in METHODS:
            row = rows.get((condition.name, method))
            if x is not None and row is not None and row.detected.of:
                marks.append(_mark(x, row, _KINDS[method]))
    return marks


def _mark(x: float, row: DetectionRate, kind: str) -> Mark:
    share = row.detected
    interval = None if share.interval is None else [100 * bound for bound in share.interval]
    hint = f"{IN_WORDS[row.method]}, {row.condition}: {number(share.percent)} % {bounds(interval)}"
    return Mark((x, share.percent), f"small {kind}", f"{hint} of {share.of}", interval)


def _of_noise(condition: ConnectedCondition) -> float | None:
    alike = condition.clocks_apart == EXACT.clocks_apart and condition.vehicles == EXACT.vehicles
    return condition.noise if alike else None


def _of_vehicles(condition: ConnectedCondition) -> float | None:
    alike = (condition.noise, condition.clocks_apart) == (USUAL.noise, USUAL.clocks_apart)
    return float(condition.vehicles) if alike else None


def _short(condition: ConnectedCondition) -> str:
    """A condition of three vehicles, or of any number, on a small drawing."""
    if (condition.noise, condition.clocks_apart) == (EXACT.noise, EXACT.clocks_apart):
        return "exact"
    return f"{condition.noise:g} m, {1000 * condition.clocks_apart:g} ms"
