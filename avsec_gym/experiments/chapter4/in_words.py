"""The results of chapter 4 in sentences."""

from __future__ import annotations

from avsec_gym.drawing.page_table import bounds, number
from avsec_gym.experiments.chapter4.attack_rates import AttackRates
from avsec_gym.experiments.chapter4.detection_rates import PAIRS
from avsec_gym.experiments.chapter4.roc_rates import RocRow
from avsec_gym.experiments.chapter4.settings import ATTACKS, EXACT, OPERATING_RATE, USUAL
from avsec_gym.experiments.chapter4.summary import ConnectedSummary
from avsec_gym.experiments.chapter4.thesis import DETECTION
from avsec_gym.metrics.clustered_shares import Share

_CONDITIONS = {
    EXACT.name: "With exact poses and clocks",
    USUAL.name: "With errors of 0.2 m and 0.2 degrees and clocks up to 100 ms apart",
}
"""The conditions that are stated in words, of three vehicles."""


def connected_sentences(summary: ConnectedSummary) -> list[str]:
    """The thesis' rates, both ROC curves, and what becomes of all attacks.

    Args:
        summary: The results of a run.
    """
    sentences = [
        f"{words}, {_of_thesis(summary, condition)}; {_of_roc(summary, condition)}."
        for condition, words in _CONDITIONS.items()
        if condition in summary.instants
    ]
    sentences += [
        _of_all(row)
        for row in summary.attacks
        if row.condition == USUAL.name and row.method == "rays"
    ]
    return sentences


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


def _of_roc(summary: ConnectedSummary, condition: str) -> str:
    rows = {(row.kind, row.method): row for row in summary.roc if row.condition == condition}
    found = " and ".join(
        f"{_curve(rows[kind, 'rays'])}, of {rows[kind, 'rays'].attacks} decidable {kind}s (surfaces"
        f" {_curve(rows[kind, 'surfaces'])})"
        for kind in ATTACKS
    )
    return f"at {100 * OPERATING_RATE:g} % false positives, rays detect {found}"


def _curve(row: RocRow) -> str:
    detected = _share(row.true_positives[str(OPERATING_RATE)])
    return f"{detected}, AUC {number(row.area.value, digits=3)}"


def _of_all(row: AttackRates) -> str:
    return (
        f"Of all {row.covered.of} {row.kind}s then, {_share(row.covered)} lie in a proposed region,"
        f" {_share(row.decidable)} are decidable, and rays detect {_share(row.detected)} at the"
        f" threshold of other places for r = {100 * OPERATING_RATE:g} %."
    )


def _share(share: Share) -> str:
    return f"{number(share.rate, 100)} % {bounds(share.interval, 100)}".strip()
