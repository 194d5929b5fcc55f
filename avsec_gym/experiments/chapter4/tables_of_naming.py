"""Tables of who is named, and of what probabilities are worth."""

from __future__ import annotations

from avsec_gym.drawing.page_table import Table, figure, name
from avsec_gym.experiments.chapter4.naming_rates import ENOUGH_WITNESSES
from avsec_gym.experiments.chapter4.settings import BY_GEOMETRY, BY_RAYS, DecidedBy
from avsec_gym.experiments.chapter4.shown_figures import (
    IN_WORDS,
    INTERVALS,
    percent,
    shown_condition,
)
from avsec_gym.experiments.chapter4.summary import ConnectedSummary

_AMONG: dict[tuple[DecidedBy, int], str] = {
    (BY_GEOMETRY, 0): "all",
    (BY_GEOMETRY, 1): "decidable and proposed",
    (BY_GEOMETRY, ENOUGH_WITNESSES): f"... with {ENOUGH_WITNESSES} witnesses or more",
    (BY_RAYS, 1): "decidable by counts",
    (BY_RAYS, ENOUGH_WITNESSES): f"... with {ENOUGH_WITNESSES} witnesses or more by counts",
}


def tables_of_naming(summary: ConnectedSummary) -> list[Table]:
    """Who is named, honest vehicles that are, and the reliability of probabilities.

    Args:
        summary: The results of a run.
    """
    return [_naming_table(summary), _honest_table(summary), _reliability_table(summary)]


def _naming_table(summary: ConnectedSummary) -> Table:
    return Table(
        "Who is named at an attack",
        [
            *("condition", "attack", "among", "method", "attacks", "victim named, %"),
            *("another, %", "cannot tell, %"),
        ],
        [
            [
                *(name(row.condition), name(row.kind), name(_AMONG[row.by, row.witnesses])),
                name(IN_WORDS[row.namer]),
                figure(row.victim.of, digits=0),
                *(percent(share) for share in (row.victim, row.another, row.cannot_tell)),
            ]
            for row in summary.namings
        ],
        "By the thresholds of the fit, in the region about the attack with the highest score; the"
        " rest does not alarm. Witnesses: by the geometry of clean scans at true poses, vehicles"
        " with which the victim’s scan can be compared there; by counts, those with which enough"
        " rays compare it under all errors, whatever they show. Of two vehicles neither is named."
        " The thesis’ rule names by distances alone; all others only whom enough independent"
        " vehicles accuse."
        f" {INTERVALS}.",
        names=4,
        sortable=True,
    )


def _honest_table(summary: ConnectedSummary) -> Table:
    return Table(
        "Instants with an honest vehicle named in any region",
        ["condition", "attack", "method", "instants", "named, %"],
        [
            [
                *(name(row.condition), name(row.state), name(IN_WORDS[row.namer])),
                figure(row.instants.of, digits=0),
                percent(row.instants),
            ]
            for row in summary.honest
        ],
        f"By the thresholds of the fit; whatever the region is about. {INTERVALS}.",
        names=3,
        sortable=True,
    )


def _reliability_table(summary: ConnectedSummary) -> Table:
    shown = shown_condition(summary)
    return Table(
        "Fitted probabilities of an attack, and how many are one",
        ["method", "probability", "regions", "mean probability, %", "attacked, %"],
        [
            [
                *(name(IN_WORDS[row.method]), name(f"{row.low:g} to {row.high:g}")),
                figure(row.attacked.of, digits=0),
                figure(row.mean, scale=100),
                percent(row.attacked),
            ]
            for row in summary.reliability
            if row.condition == shown
        ],
        f"{shown}. All regions of judged attack-free instants, and those about the ghost and the"
        " removal of the same instants, as far as vehicles have reported counts of them: a mixture"
        f" like that of the fit, in which attacks are more frequent than on a road. {INTERVALS}.",
        names=2,
    )
