"""The results of chapter 4 in sentences."""

from __future__ import annotations

from avsec_gym.drawing.page_table import bounds, number
from avsec_gym.experiments.chapter4.attack_rates import AttackRates
from avsec_gym.experiments.chapter4.clean_rays import LEAST_RAYS
from avsec_gym.experiments.chapter4.detection_rates import PAIRS, REGIONS, DetectionRate
from avsec_gym.experiments.chapter4.naming_rates import ENOUGH_WITNESSES
from avsec_gym.experiments.chapter4.settings import (
    ATTACKS,
    BY_GEOMETRY,
    BY_RAYS,
    EXACT,
    EXACT_RATE,
    FIVE,
    OPERATING_RATE,
    USUAL,
)
from avsec_gym.experiments.chapter4.summary import ConnectedSummary
from avsec_gym.experiments.chapter4.thesis import DETECTION
from avsec_gym.metrics.clustered_shares import Share
from avsec_gym.metrics.roc_curve import RocArea
from avsec_gym.validation.connected.result import AttackKind
from avsec_gym.validation.connected.validator import Method

_CONDITIONS = {
    EXACT.name: ("With exact poses and clocks", EXACT_RATE),
    USUAL.name: (
        "With errors of 0.2 m and 0.2 degrees and clocks up to 100 ms apart",
        OPERATING_RATE,
    ),
}
"""The conditions that are stated in words, of three vehicles, and the rate of each."""


def connected_sentences(summary: ConnectedSummary) -> list[str]:
    """The thesis' rates, detection at held-out thresholds, what becomes of all attacks, and names.

    Args:
        summary: The results of a run.
    """
    sentences = []
    for condition, (words, rate) in _CONDITIONS.items():
        if condition in summary.instants:
            sentences += [_of_thesis(summary, condition, words)]
            sentences += [_of_rays(summary, condition, words, kind, rate) for kind in ATTACKS]
            sentences += [_of_false_alarms(summary, condition, words, rate)]
    sentences += [
        _of_all(row)
        for row in summary.attacks
        if row.condition == USUAL.name and row.method == "rays"
    ]
    return [*sentences, *_of_names(summary)]


def _of_names(summary: ConnectedSummary) -> list[str]:
    """Whom rays name of five vehicles."""
    rows = {
        (row.kind, row.by): row
        for row in summary.namings
        if (row.condition, row.namer, row.witnesses) == (FIVE.name, "rays", ENOUGH_WITNESSES)
    }
    honest = {
        row.state: row.instants
        for row in summary.honest
        if (row.condition, row.namer) == (FIVE.name, "rays")
    }
    return [
        f"With five vehicles, rays name the victim of {_share(row.victim)} and another vehicle of"
        f" {_share(row.another)} of {row.victim.of} {kind}s of which {row.witnesses} witnesses or"
        f" more have {LEAST_RAYS} rays, and of {_share(clean.victim)} and"
        f" {_share(clean.another)} of the {clean.victim.of} of which so many clean scans at true"
        f" poses have them; an honest vehicle is named in any region at {_share(honest[kind])} of"
        " the instants."
        for (kind, by), row in rows.items()
        if by == BY_RAYS
        for clean in [rows[kind, BY_GEOMETRY]]
    ]


def _of_thesis(summary: ConnectedSummary, condition: str, words: str) -> str:
    rows = {
        row.rate: row.detected
        for row in summary.detection
        if (row.condition, row.kind, row.of) == (condition, "ghost", PAIRS)
    }
    found = " and ".join(
        f"{_share(rows[rate])} at r = {rate:g} (thesis: {number(share, 100, 0)} %)"
        for rate, share in DETECTION.items()
    )
    return f"{words}, the thesis’ method detects {found} of {rows[0.0].of} decidable ghosts."


def _of_rays(
    summary: ConnectedSummary, condition: str, words: str, kind: AttackKind, rate: float
) -> str:
    rows = _at_rate(summary, condition, kind, rate)
    areas = {
        row.method: row for row in summary.roc if (row.condition, row.kind) == (condition, kind)
    }
    of_rays, area = rows["rays"], areas["rays"]
    return (
        f"{words}, at r = {rate:g} rays detect"
        f" {_detected(of_rays.detected_by_rays, area.area_by_rays)}, of"
        f" {of_rays.detected_by_rays.of} {kind}s of which some witness has {LEAST_RAYS} rays, and"
        f" {_detected(of_rays.detected, area.area)}, of the {of_rays.detected.of} of which clean"
        f" scans at true poses have them; of these, surfaces detect"
        f" {_detected(rows['surfaces'].detected, areas['surfaces'].area)}."
    )


def _of_false_alarms(summary: ConnectedSummary, condition: str, words: str, rate: float) -> str:
    rows = _at_rate(summary, condition, ATTACKS[0], rate)
    return (
        f"{words}, {_share(rows['rays'].false_alarms)} of the judged attack-free regions exceed"
        f" the threshold of rays for r = {rate:g},"
        f" {_share(rows['surfaces'].false_alarms)} that of surfaces; both are of other places."
    )


def _at_rate(
    summary: ConnectedSummary, condition: str, kind: AttackKind, rate: float
) -> dict[Method, DetectionRate]:
    """Detection of an attack at thresholds for a rate, by method."""
    return {
        row.method: row
        for row in summary.detection
        if (row.condition, row.of, row.rate, row.kind) == (condition, REGIONS, rate, kind)
    }


def _detected(detected: Share, area: RocArea) -> str:
    return f"{_share(detected)}, AUC {number(area.value, digits=3)}"


def _of_all(row: AttackRates) -> str:
    return (
        f"Of all {row.covered.of} {row.kind}s with these errors, {_share(row.covered)} lie in a"
        f" proposed region, {_share(row.decidable)} are decidable, and rays detect"
        f" {_share(row.detected)} at the same threshold."
    )


def _share(share: Share) -> str:
    return f"{number(share.rate, 100)} % {bounds(share.interval, 100)}".strip()
