"""The tables of chapter 4."""

from __future__ import annotations

from collections.abc import Sequence

from avsec_gym.drawing.page_table import Table, TableCell, figure, name
from avsec_gym.experiments.chapter4.attack_rates import AttackRates
from avsec_gym.experiments.chapter4.detection_rates import PAIRS, REGIONS, DetectionRate
from avsec_gym.experiments.chapter4.distance_distributions import DistanceDistribution
from avsec_gym.experiments.chapter4.false_alarms import InstantFalseAlarms
from avsec_gym.experiments.chapter4.roc_rates import RocRow
from avsec_gym.experiments.chapter4.sent_bytes import SentBytes
from avsec_gym.experiments.chapter4.settings import (
    ATTACKS,
    CLEAN,
    FITTED,
    JUDGED,
    OPERATING_RATE,
    RATES,
)
from avsec_gym.experiments.chapter4.step_times import StepTime
from avsec_gym.experiments.chapter4.summary import ConnectedSummary
from avsec_gym.experiments.chapter4.thesis import DETECTION, DISTANCE_BOUND
from avsec_gym.metrics.clustered_shares import Share

IN_WORDS = {"surfaces": "surfaces (thesis)", "rays": "rays", "learned": "learned of both"}
_INTERVALS = "In brackets: 95 % intervals, which know that regions of one instant are alike"


def tables_of_connected(summary: ConnectedSummary) -> list[Table]:
    """All of a run.

    Args:
        summary: The results of the run.
    """
    return [
        _roc_table(summary.roc),
        _detection_table(summary.detection),
        _attack_table(summary.attacks),
        _alarm_table(summary.false_alarms),
        _distance_table(summary.distances),
        _bytes_table(summary.sent),
        *([_time_table(summary.times)] if summary.times else []),
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
                *(_percent(row.true_positives[str(rate)]) for rate in RATES),
            ]
            for row in rows
        ],
        "Decidable, for all methods alike: some vehicle has at least five rays at what another"
        " claims, whatever they tell. True positive rates, %, at thresholds that this share of the"
        f" judged attack-free regions exceeds. {_INTERVALS} (AUC: bootstrap over instants; rates:"
        " Wilson’s, widened, for a given threshold).",
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
                *(_percent(row.detected, _of_thesis(row)) for row in by_kind[kind]),
            ]
            for kind in ATTACKS
        ]
        alarms = [_percent(row.false_alarms) for row in by_kind[ATTACKS[0]]]
        lines.append([*start, name("none: false alarms"), *alarms])
    return Table(
        "Detection at thresholds of other places, %",
        ["condition", "method", "r of", "attack", *(f"r = {100 * rate:g} %" for rate in rates)],
        lines,
        f"Of decidable attacks and attack-free regions. r is a share of {REGIONS}, or of the"
        f" distances of {PAIRS} of surfaces, as in the thesis: three vehicles make three pairs of"
        " a region, so that more regions alarm. Thresholds: of attack-free instants of other places"
        " and assets. In italics: the thesis, for ghosts, on three scans of a static recording."
        f" {_INTERVALS}.",
        names=4,
        sortable=True,
    )


def _of_thesis(row: DetectionRate) -> float | None:
    own = row.kind == "ghost" and row.of == PAIRS
    return DETECTION.get(row.rate) if own else None


def _attack_table(rows: Sequence[AttackRates]) -> Table:
    shares = (
        "covered",
        "decidable",
        "detected",
        "of_decidable",
        "victim",
        "another",
        "cannot_tell",
    )
    return Table(
        "All attacks, end to end",
        [
            *("condition", "attack", "method", "attacks", "proposed, %", "decidable, %"),
            *("detected, %", "of decidable, %", "victim named, %", "another, %", "cannot tell, %"),
        ],
        [
            [
                *(name(row.condition), name(row.kind), name(IN_WORDS[row.method])),
                figure(row.covered.of, digits=0),
                *(_percent(getattr(row, share)) for share in shares),
            ]
            for row in rows
        ],
        "Of all attacks: an attack that no proposed region covers, or that no other vehicle sees,"
        f" is a miss. Detected: above the threshold of other places at r = {100 * OPERATING_RATE:g}"
        " % of regions. Named: by the thresholds of the fit; of two vehicles neither is named."
        f" {_INTERVALS}.",
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
                _percent(row.regions),
                _percent(row.frames),
                figure(row.each_frame, digits=2),
                _percent(row.decidable),
            ]
            for row in rows
        ],
        "Of judged attack-free instants at thresholds of other places, over decidable regions: a"
        f" frame, one instant of all vehicles, has many. {_INTERVALS}.",
        names=2,
        sortable=True,
    )


def _distance_table(rows: Sequence[DistanceDistribution]) -> Table:
    states = (CLEAN, *ATTACKS)
    return Table(
        f"Distances of surfaces below {DISTANCE_BOUND:g} m",
        ["condition", *(f"{state}, %" for state in states), "distances"],
        [
            [
                name(row.condition),
                *(_percent(row.below[state]) for state in states),
                name(" / ".join(str(row.below[state].of) for state in states)),
            ]
            for row in rows
        ],
        "Equation 4.1; of pairs of vehicles, under an attack of the victim with each other. In the"
        " thesis most attack-free distances lie below this bound, and most attacked ones above."
        f" {_INTERVALS}.",
    )


def _bytes_table(rows: Sequence[SentBytes]) -> Table:
    return Table(
        "Bytes that a vehicle sends at an instant",
        ["condition", "method", "mean", "most"],
        [
            [
                *(name(row.condition), name(IN_WORDS[row.method])),
                figure(row.mean, digits=0),
                figure(row.most, digits=0),
            ]
            for row in rows
        ],
        "Attack-free; proposals are among it.",
        names=2,
    )


def _time_table(rows: Sequence[StepTime]) -> Table:
    return Table(
        "CPU time of an instant of three vehicles",
        ["method", "where", "step", "ms", "instants"],
        [
            [
                *(name(IN_WORDS[row.method]), name(row.where), name(row.step)),
                figure(1000 * row.seconds),
                figure(row.instants, digits=0),
            ]
            for row in rows
        ],
        "Means of one core of the run’s machine, of one vehicle where vehicles do it.",
        names=3,
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


def _percent(share: Share, thesis: float | None = None) -> TableCell:
    return figure(share.rate, share.interval, thesis, scale=100)
