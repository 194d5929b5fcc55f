"""Tables of what detection depends on: the distance of an attack, and what was removed."""

from __future__ import annotations

from avsec_gym.drawing.page_table import Table, figure, name
from avsec_gym.experiments.chapter4.settings import METHODS, OPERATING_RATE
from avsec_gym.experiments.chapter4.shown_figures import (
    IN_WORDS,
    INTERVALS,
    percent,
    shown_condition,
)
from avsec_gym.experiments.chapter4.summary import ConnectedSummary
from avsec_gym.validation.connected.proposals.clusters import ClusterProposer

_PROPOSER = ClusterProposer()
_AT = f"at the threshold of other places for r = {100 * OPERATING_RATE:g} %"


def tables_of_factors(summary: ConnectedSummary) -> list[Table]:
    """Rates over distance, and of the categories of what was removed.

    Args:
        summary: The results of a run.
    """
    return [_distance_table(summary), _category_table(summary)]


def _distance_table(summary: ConnectedSummary) -> Table:
    shown = shown_condition(summary)
    return Table(
        "Attacks by their distance from the victim",
        [
            *("attack", "distance, m", "attacks", "proposed, %", "decidable, %"),
            *("decidable and proposed", *(f"{IN_WORDS[method]}, %" for method in METHODS)),
        ],
        [
            [
                *(name(row.kind), name(f"{row.nearest:g} to {row.farthest:g}")),
                figure(row.covered.of, digits=0),
                percent(row.covered),
                percent(row.decidable),
                figure(row.detected[METHODS[0]].of, digits=0),
                *(percent(row.detected[method]) for method in METHODS),
            ]
            for row in summary.by_distance
            if row.condition == shown
        ],
        f"{shown}. By method: of those that are decidable and proposed, detected {_AT}."
        f" {INTERVALS}.",
        names=2,
    )


def _category_table(summary: ConnectedSummary) -> Table:
    shown = shown_condition(summary)
    return Table(
        "What was removed",
        ["category", "removed", "proposed, %", "decidable, %", "detected by rays, %"],
        [
            [
                name(row.category or "not known"),
                figure(row.covered.of, digits=0),
                *(percent(share) for share in (row.covered, row.decidable, row.detected)),
            ]
            for row in summary.removed
            if row.condition == shown
        ],
        f"{shown}. Of all removals of a category; detected {_AT}. Regions are proposed for what is"
        f" {_PROPOSER.shortest:g} m long or more and {_PROPOSER.tallest:g} m high or less, as cars"
        f" are, and people and trucks are not. {INTERVALS}.",
    )
