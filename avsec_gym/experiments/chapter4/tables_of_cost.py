"""Tables of bytes and of computing time."""

from __future__ import annotations

from avsec_gym.drawing.page_table import Table, figure, name
from avsec_gym.experiments.chapter4.settings import ATTACKS
from avsec_gym.experiments.chapter4.shown_figures import IN_WORDS, shown_condition
from avsec_gym.experiments.chapter4.summary import ConnectedSummary


def tables_of_cost(summary: ConnectedSummary) -> list[Table]:
    """Bytes by method and by kind of message, times of whole instants and of their steps.

    Args:
        summary: The results of a run.
    """
    return [
        _bytes_table(summary),
        _kinds_table(summary),
        _instant_time_table(summary),
        *([_step_time_table(summary)] if summary.times else []),
    ]


def _bytes_table(summary: ConnectedSummary) -> Table:
    areas = {(row.condition, row.method, row.kind): row.area for row in summary.roc}
    lines = []
    for row in summary.sent:
        found = [areas[row.condition, row.method, kind] for kind in ATTACKS]
        lines.append(
            [
                *(name(row.condition), name(IN_WORDS[row.method])),
                figure(row.mean, digits=0),
                figure(row.most, digits=0),
                *(figure(area.value, area.interval, digits=3) for area in found),
            ]
        )
    return Table(
        "Bytes that a vehicle sends at an instant, and what they buy",
        ["condition", "method", "mean", "most", *(f"AUC, {kind}s" for kind in ATTACKS)],
        lines,
        "Bytes of attack-free instants, proposals among them; AUC over decidable regions, as"
        " above.",
        names=2,
        sortable=True,
    )


def _kinds_table(summary: ConnectedSummary) -> Table:
    shown = shown_condition(summary)
    return Table(
        "Bytes by kind of message",
        ["sender", "kind", "mean", "most"],
        [
            [
                *(name(row.sender), name(row.kind)),
                figure(row.mean, digits=0),
                figure(row.most, digits=0),
            ]
            for row in summary.sent_kinds
            if row.condition == shown
        ],
        f"{shown}, attack-free. Of one vehicle at one instant; the base station’s go to all at"
        " once. Crops are for surfaces, claims and counts for rays.",
        names=2,
    )


def _instant_time_table(summary: ConnectedSummary) -> Table:
    return Table(
        "CPU time of an instant after the proposals",
        [
            *("condition", "attack", "method", "median, ms", "largest, ms", "a region, ms"),
            *("regions", "instants"),
        ],
        [
            [
                *(name(row.condition), name(row.state), name(IN_WORDS[row.method])),
                figure(1000 * row.median),
                figure(1000 * row.largest),
                figure(None if row.of_region is None else 1000 * row.of_region, digits=2),
                figure(row.regions, digits=1),
                figure(row.instants, digits=0),
            ]
            for row in summary.after_proposals
        ],
        "Of all vehicles and the base station together, on one core of the run’s machine; of a"
        " region, and the mean number of them, where attack-free instants are judged by all.",
        names=3,
        sortable=True,
    )


def _step_time_table(summary: ConnectedSummary) -> Table:
    return Table(
        "CPU time of the steps of an instant of three vehicles",
        ["method", "where", "step", "ms", "instants"],
        [
            [
                *(name(IN_WORDS[row.method]), name(row.where), name(row.step)),
                figure(1000 * row.seconds),
                figure(row.instants, digits=0),
            ]
            for row in summary.times
        ],
        "Means of one core of the run’s machine, of one vehicle where vehicles do it.",
        names=3,
    )
