"""The results of chapter 4 in sentences."""

from __future__ import annotations

from avsec_gym.drawing.page_table import bounds, number
from avsec_gym.experiments.chapter4.attack_rates import AttackRates
from avsec_gym.experiments.chapter4.detection_rates import PAIRS
from avsec_gym.experiments.chapter4.roc_rates import RocRow
from avsec_gym.experiments.chapter4.settings import ATTACKS, EXACT, METHODS, OPERATING_RATE, USUAL
from avsec_gym.experiments.chapter4.summary import ConnectedSummary
from avsec_gym.experiments.chapter4.tables import IN_WORDS
from avsec_gym.experiments.chapter4.thesis import DETECTION
from avsec_gym.metrics.clustered_shares import Share

_AT = f"{OPERATING_RATE:g}"


def connected_sentences(summary: ConnectedSummary) -> list[str]:
    """The thesis' rates, both ROC curves, and what becomes of all attacks.

    Args:
        summary: The results of a run.
    """
    conditions = [each for each in (EXACT, USUAL) if each.name in summary.instants]
    sentences = []
    for condition in conditions:
        rows = {
            row.rate: row.detected
            for row in summary.detection
            if (row.condition, row.kind, row.of) == (condition.name, "ghost", PAIRS)
        }
        found = " and ".join(
            f"{_share(rows[rate])} at r = {rate:g} (thesis: {number(share, 100, 0)} %)"
            for rate, share in DETECTION.items()
        )
        sentences.append(f"{condition.name}: the thesis’ method detects {found} of the ghosts.")
        sentences += [_of_roc(summary, condition.name, kind) for kind in ATTACKS]
    if USUAL in conditions:
        rows_of_all = {
            (row.kind, row.method): row for row in summary.attacks if row.condition == USUAL.name
        }
        sentences += [_of_all(rows_of_all[kind, "rays"]) for kind in ATTACKS]
    return sentences


def _of_roc(summary: ConnectedSummary, condition: str, kind: str) -> str:
    rows = [row for row in summary.roc if (row.condition, row.kind) == (condition, kind)]
    by_method = {row.method: row for row in rows}
    told = "; ".join(f"{IN_WORDS[method]} {_curve(by_method[method])}" for method in METHODS)
    return f"{condition}, {rows[0].attacks} decidable {kind}s: {told}."


def _curve(row: RocRow) -> str:
    area = f"{number(row.area.value, digits=3)} {bounds(row.area.interval, digits=3)}"
    return f"AUC {area}, {_share(row.true_positives[_AT])} at {100 * OPERATING_RATE:g} % FPR"


def _of_all(row: AttackRates) -> str:
    return (
        f"{row.condition}: of {row.covered.of} {row.kind}s, {_share(row.covered)} lie in a proposed"
        f" region, {_share(row.decidable)} are decidable, and {_share(row.detected)} are detected"
        f" by rays at a held-out threshold."
    )


def _share(share: Share) -> str:
    return f"{number(share.rate, 100)} % {bounds(share.interval, 100)}".strip()
