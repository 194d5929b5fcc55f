"""The tables of chapter 4."""

from __future__ import annotations

from collections.abc import Sequence

from avsec_gym.drawing.page_table import Table, figure, name
from avsec_gym.experiments.chapter4.attack_rates import AttackRates
from avsec_gym.experiments.chapter4.clean_rays import LEAST_RAYS
from avsec_gym.experiments.chapter4.detection_rates import PAIRS, REGIONS, DetectionRate
from avsec_gym.experiments.chapter4.distance_distributions import DistanceDistribution
from avsec_gym.experiments.chapter4.false_alarms import InstantFalseAlarms
from avsec_gym.experiments.chapter4.roc_rates import RocRow
from avsec_gym.experiments.chapter4.settings import (
    ATTACKS,
    CLEAN,
    FITTED,
    JUDGED,
    OPERATING_RATE,
    RATES,
)
from avsec_gym.experiments.chapter4.shown_figures import IN_WORDS, INTERVALS, percent
from avsec_gym.experiments.chapter4.summary import ConnectedSummary
from avsec_gym.experiments.chapter4.tables_of_cost import tables_of_cost
from avsec_gym.experiments.chapter4.tables_of_factors import tables_of_factors
from avsec_gym.experiments.chapter4.tables_of_naming import tables_of_naming
from avsec_gym.experiments.chapter4.thesis import DETECTION, DISTANCE_BOUND


def tables_of_connected(summary: ConnectedSummary) -> list[Table]:
    """All of a run.

    Args:
        summary: The results of the run.
    """
    return [
        _detection_table(summary.detection),
        _roc_table(summary.roc),
        _attack_table(summary.attacks),
        _both_sets_table(summary),
        _alarm_table(summary.false_alarms),
        _distance_table(summary.distances),
        *tables_of_naming(summary),
        *tables_of_factors(summary),
        *tables_of_cost(summary),
        _instant_table(summary),
    ]


def _roc_table(rows: Sequence[RocRow]) -> Table:
    return Table(
        "ROC over decidable regions",
        [
            *("condition", "attack", "method", "attacks", "regions", "AUC"),
            *(f"TPR at {100 * rate:g} %" for rate in RATES),
        ],
        [
            [
                *(name(row.condition), name(row.kind), name(IN_WORDS[row.method])),
                figure(row.attacks, digits=0),
                figure(row.regions, digits=0),
                figure(row.area.value, row.area.interval, digits=3),
                *(percent(row.true_positives[str(rate)]) for rate in RATES),
            ]
            for row in rows
        ],
        "Decidable, for all methods and errors of poses alike: by clean scans at true poses, some"
        f" vehicle has {LEAST_RAYS} rays or more, none of which ends in front, at what another"
        " claims; of a ghost, a vehicle other than the victim at what the victim claims; of a"
        " removal, the victim at what another one claims. True positive rates, %, at thresholds"
        " that this share of the judged attack-free regions themselves exceeds: a curve, not what"
        f" a fixed threshold reaches. {INTERVALS} (AUC: bootstrap over instants; rates: Wilson’s,"
        " widened, for a given threshold).",
        names=3,
        sortable=True,
    )


def _detection_table(rows: Sequence[DetectionRate]) -> Table:
    rates = (*RATES, max(DETECTION))
    found = {(row.condition, row.method, row.of, row.kind, row.rate): row for row in rows}
    settings = dict.fromkeys((row.condition, row.method, row.of) for row in rows)
    lines = []
    for condition, method, of in settings:
        start = [name(condition), name(IN_WORDS[method]), name(of)]
        by_kind = {
            kind: [found[condition, method, of, kind, rate] for rate in rates] for kind in ATTACKS
        }
        lines += [
            [
                *start,
                name(kind),
                *(percent(row.detected, _of_thesis(row)) for row in by_kind[kind]),
            ]
            for kind in ATTACKS
        ]
        alarms = [percent(row.false_alarms) for row in by_kind[ATTACKS[0]]]
        lines.append([*start, name("none: false alarms"), *alarms])
    return Table(
        "Detection at thresholds of other places, %",
        ["condition", "method", "r of", "attack", *(f"r = {100 * rate:g} %" for rate in rates)],
        lines,
        f"Of decidable attacks and attack-free regions. r is a share of {REGIONS}, or of the"
        f" distances of {PAIRS} of surfaces, as in the thesis: three vehicles make three pairs of"
        " a region, so that more regions alarm. Thresholds: of attack-free instants of other places"
        " and assets. In italics: the thesis, for ghosts, on three scans of a static recording."
        f" {INTERVALS}.",
        names=4,
        sortable=True,
    )


def _of_thesis(row: DetectionRate) -> float | None:
    own = row.kind == "ghost" and row.of == PAIRS
    return DETECTION.get(row.rate) if own else None


def _attack_table(rows: Sequence[AttackRates]) -> Table:
    shares = ("covered", "decidable", "detected", "of_decidable", "of_regions")
    return Table(
        "All attacks, end to end",
        [
            *("condition", "attack", "method", "attacks", "proposed, %", "decidable, %"),
            *("detected, %", "of decidable, %", "of decidable and proposed, %"),
        ],
        [
            [
                *(name(row.condition), name(row.kind), name(IN_WORDS[row.method])),
                figure(row.covered.of, digits=0),
                *(percent(getattr(row, share)) for share in shares),
            ]
            for row in rows
        ],
        "Of all attacks: an attack that no proposed region covers, or that no other vehicle sees,"
        f" is a miss. Detected: above the threshold of other places at r = {100 * OPERATING_RATE:g}"
        f" % of regions. {INTERVALS}.",
        names=3,
        sortable=True,
    )


def _both_sets_table(summary: ConnectedSummary) -> Table:
    areas = {(row.condition, row.kind, row.method): row for row in summary.roc}
    rows = [row for row in summary.detection if (row.of, row.rate) == (REGIONS, OPERATING_RATE)]
    return Table(
        "What decides which regions are decidable",
        [
            *("condition", "attack", "method", "by geometry: attacks", "detected, %"),
            *("false alarms, %", "AUC", "by the method of rays: attacks", "detected by it, %"),
            *("false alarms by it, %", "AUC by it"),
        ],
        [
            [
                *(name(row.condition), name(row.kind), name(IN_WORDS[row.method])),
                figure(row.detected.of, digits=0),
                percent(row.detected),
                percent(row.false_alarms),
                figure(area.area.value, area.area.interval, digits=3),
                figure(row.detected_by_rays.of, digits=0),
                percent(row.detected_by_rays),
                percent(row.false_alarms_by_rays),
                figure(area.area_by_rays.value, area.area_by_rays.interval, digits=3),
            ]
            for row in rows
            for area in [areas[row.condition, row.kind, row.method]]
        ],
        f"At thresholds of other places for r = {100 * OPERATING_RATE:g} % of regions. By geometry:"
        " as in all other tables. By the method of rays: some pair of vehicles, whoever is"
        " attacked, has reported counts enough of the scans as they are, with errors of poses and"
        f" within the budget of bytes. {INTERVALS}.",
        names=3,
        sortable=True,
    )


def _alarm_table(rows: Sequence[InstantFalseAlarms]) -> Table:
    return Table(
        "False alarms for each region and for each frame",
        [
            *("condition", "method", "r of regions, %", "regions that alarm, %"),
            *("frames that alarm, %", "alarms a frame", "decidable regions, %"),
        ],
        [
            [
                *(name(row.condition), name(IN_WORDS[row.method])),
                figure(row.rate, scale=100, digits=0),
                percent(row.regions),
                percent(row.frames),
                figure(row.each_frame, digits=2),
                percent(row.decidable),
            ]
            for row in rows
        ],
        "Of judged attack-free instants at thresholds of other places, over decidable regions: a"
        f" frame, one instant of all vehicles, has many. {INTERVALS}.",
        names=2,
        sortable=True,
    )


def _distance_table(rows: Sequence[DistanceDistribution]) -> Table:
    states = (CLEAN, *ATTACKS)
    return Table(
        f"Distances of surfaces below {DISTANCE_BOUND:g} m",
        [
            *("condition", *(f"{state}, %" for state in states), "distances"),
            *(f"{state}: pairs compared, %" for state in states),
        ],
        [
            [
                name(row.condition),
                *(percent(row.below[state]) for state in states),
                name(" / ".join(str(row.below[state].of) for state in states)),
                *(percent(row.compared[state]) for state in states),
            ]
            for row in rows
        ],
        "Equation 4.1; of pairs of vehicles, under an attack of the victim with each other. In the"
        " thesis most attack-free distances lie below this bound, and most attacked ones above."
        " Pairs compared: both have points enough in the region; the others have no distance."
        f" {INTERVALS}.",
    )


def _instant_table(summary: ConnectedSummary) -> Table:
    return Table(
        "Instants",
        ["condition", FITTED, JUDGED],
        [
            [name(condition), *(figure(counts[part], digits=0) for part in (FITTED, JUDGED))]
            for condition, counts in summary.instants.items()
        ],
        "Each at a place of its own; fitted and judged places share no assets.",
    )
