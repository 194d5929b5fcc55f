"""The results of chapter 4 in sentences."""

from __future__ import annotations

from avsec_gym.drawing.page_table import bounds, number
from avsec_gym.experiments.chapter4.attack_rates import AttackRates
from avsec_gym.experiments.chapter4.detection_rates import PAIRS, REGIONS, DetectionRate
from avsec_gym.experiments.chapter4.naming_rates import ENOUGH_WITNESSES
from avsec_gym.experiments.chapter4.roc_rates import RocRow
from avsec_gym.experiments.chapter4.settings import ATTACKS, EXACT, FIVE, OPERATING_RATE, USUAL
from avsec_gym.experiments.chapter4.summary import ConnectedSummary
from avsec_gym.experiments.chapter4.thesis import DETECTION
from avsec_gym.metrics.clustered_shares import Share

_CONDITIONS = {
    EXACT.name: "With exact poses and clocks",
    USUAL.name: "With errors of 0.2 m and 0.2 degrees and clocks up to 100 ms apart",
}
"""The conditions that are stated in words, of three vehicles."""


def connected_sentences(summary: ConnectedSummary) -> list[str]:
    """The thesis' rates, detection at held-out thresholds, what becomes of all attacks, and names.

    Args:
        summary: The results of a run.
    """
    sentences = [
        f"{words}, {_of_thesis(summary, condition)}; {_of_rays(summary, condition)}."
        for condition, words in _CONDITIONS.items()
        if condition in summary.instants
    ]
    sentences += [
        _of_all(row)
        for row in summary.attacks
        if row.condition == USUAL.name and row.method == "rays"
    ]
    return [*sentences, *_of_names(summary)]


def _of_names(summary: ConnectedSummary) -> list[str]:
    """Whom rays name of five vehicles."""
    rows = [
        row
        for row in summary.namings
        if (row.condition, row.namer, row.witnesses) == (FIVE.name, "rays", ENOUGH_WITNESSES)
    ]
    honest = {
        row.state: row.instants
        for row in summary.honest
        if (row.condition, row.namer) == (FIVE.name, "rays")
    }
    return [
        f"With five vehicles, rays name the victim of {_share(row.victim)} and another vehicle of"
        f" {_share(row.another)} of {row.victim.of} decidable {row.kind}s with {row.witnesses}"
        f" witnesses or more; an honest vehicle is named in any region at"
        f" {_share(honest[row.kind])} of the instants."
        for row in rows
    ]


def _of_thesis(summary: ConnectedSummary, condition: str) -> str:
    rows = {
        row.rate: row.detected
        for row in summary.detection
        if (row.condition, row.kind, row.of) == (condition, "ghost", PAIRS)
    }
    found = " and ".join(
        f"{_share(rows[rate])} at r = {rate:g} (thesis: {number(share, 100, 0)} %)"
        for rate, share in DETECTION.items()
    )
    return f"the thesis’ method detects {found} of {rows[0.0].of} decidable ghosts"


def _of_rays(summary: ConnectedSummary, condition: str) -> str:
    areas = {(row.kind, row.method): row for row in summary.roc if row.condition == condition}
    rows = {
        (row.kind, row.method): row
        for row in summary.detection
        if (row.condition, row.of, row.rate) == (condition, REGIONS, OPERATING_RATE)
    }
    found = " and ".join(
        f"{_detected(rows[kind, 'rays'], areas[kind, 'rays'])}, of"
        f" {rows[kind, 'rays'].detected.of} decidable {kind}s (surfaces"
        f" {_detected(rows[kind, 'surfaces'], areas[kind, 'surfaces'])})"
        for kind in ATTACKS
    )
    alarms = {method: rows[ATTACKS[0], method].false_alarms for method in ("rays", "surfaces")}
    return (
        f"at the thresholds of other places for r = {100 * OPERATING_RATE:g} %, which"
        f" {_share(alarms['rays'])} of the judged attack-free regions exceed by rays and"
        f" {_share(alarms['surfaces'])} by surfaces, rays detect {found}"
    )


def _detected(row: DetectionRate, curve: RocRow) -> str:
    return f"{_share(row.detected)}, AUC {number(curve.area.value, digits=3)}"


def _of_all(row: AttackRates) -> str:
    return (
        f"Of all {row.covered.of} {row.kind}s then, {_share(row.covered)} lie in a proposed region,"
        f" {_share(row.decidable)} are decidable, and rays detect {_share(row.detected)} at the"
        f" threshold of other places for r = {100 * OPERATING_RATE:g} %."
    )


def _share(share: Share) -> str:
    return f"{number(share.rate, 100)} % {bounds(share.interval, 100)}".strip()
