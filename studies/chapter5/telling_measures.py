"""Which measure of perception predicts driving safety, over attacks?

Average precision counts cars that no episode comes near, and wants boxes that fit closely.
Measures of the cars in reach, which forgive a box that stands a little aside, and measures that
know where the car wants to go are compared with safety in the same way.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from avsec_gym.experiments.chapter5.losses import TRUE_ATTACKS, precision, safety
from avsec_gym.experiments.chapter5.outcomes import RESAMPLES, Condition, Outcomes
from avsec_gym.experiments.chapter5.settings import FAMILIES
from avsec_gym.experiments.json_rows import OPTIONAL
from avsec_gym.metrics.average_precision import LOW_IOU, STANDARD_IOU
from avsec_gym.metrics.cluster_bootstrap import (
    ClusterBootstrap,
    Sampled,
    sampled_rank_correlation,
)
from avsec_gym.metrics.estimate import NOTHING, Estimate
from avsec_gym.metrics.many_comparisons import holm_adjusted
from studies.chapter5.case_measures import CASE_MEASURES, CaseMeasures

PRECISION, LOW_PRECISION = "AP, IoU 0.7", "AP, IoU 0.5"
PRECISIONS = {PRECISION: STANDARD_IOU, LOW_PRECISION: LOW_IOU}
MEASURES = (*PRECISIONS, *CASE_MEASURES)
"""The usual one first."""
BOTH = "both"
ALL_ATTACKS = "all"


@dataclass(frozen=True)
class MeasureRow:
    """How far the loss of a measure goes with the loss of safety.

    Args:
        measure: One of `MEASURES`.
        detector: The detector, or ``both``.
        family: The attacks that count: ``all``, or one of `FAMILIES`.
        attacks: Number of attacks.
        rho: Spearman's rank correlation.
        interval: 95 % interval of `rho`, by bootstrap over scenarios; both losses from one draw.
        more: How much larger it is than that of the average precision.
        p_holm: The p-value of `more`'s being zero, after Holm's correction for all rows; None of
            the average precision itself, where there is no `more`, and in earlier results.
    """

    measure: str
    detector: str
    family: str
    attacks: int
    rho: float | None
    interval: Sequence[float] | None
    more: Estimate
    p_holm: float | None = field(default=None, metadata=OPTIONAL)


def compared_attacks(outcomes: Outcomes) -> list[Condition]:
    """The attacks that are compared: perturbations and patches in float."""
    return [
        condition
        for condition in outcomes.conditions
        if condition.attack in TRUE_ATTACKS
        and not condition.whole_levels
        and condition.unattacked in outcomes.conditions
    ]


def groups_of(attacks: Sequence[Condition]) -> dict[tuple[str, str], list[Condition]]:
    """The attacks by detector and family, ``both`` and ``all`` among them."""
    groups: dict[tuple[str, str], list[Condition]] = {}
    for detector in (*dict.fromkeys(attack.detector for attack in attacks), BOTH):
        of_detector = [attack for attack in attacks if detector in (attack.detector, BOTH)]
        groups[detector, ALL_ATTACKS] = of_detector
        for family, names in FAMILIES.items():
            groups[detector, family] = [each for each in of_detector if each.attack in names]
    return groups


def telling_rows(outcomes: Outcomes, cases: CaseMeasures) -> list[MeasureRow]:
    """How far the loss of each measure goes with the loss of safety, over the attacks.

    Args:
        outcomes: The outcomes of a run.
        cases: The measures of its cases, unattacked and under each of `compared_attacks`.

    Returns:
        A row for each measure, detector and family, ``both`` and ``all`` among them.
    """
    attacks = compared_attacks(outcomes)
    looked = dict.fromkeys([*(attack.unattacked for attack in attacks), *attacks])
    safe = _lost({each: safety(outcomes, each) for each in looked}, attacks)
    rows: list[MeasureRow] = []
    p_values: list[float] = []
    usual: dict[tuple[str, str], Sampled | None] = {}
    for measure in MEASURES:
        lost = _lost({each: _of_all(measure, outcomes, each, cases) for each in looked}, attacks)
        for (detector, family), group in groups_of(attacks).items():
            rho = sampled_rank_correlation([(lost[attack], safe[attack]) for attack in group])
            first = usual.setdefault((detector, family), rho)
            more = None if rho is None or first is None else rho - first
            rows.append(
                MeasureRow(
                    measure,
                    detector,
                    family,
                    len(group),
                    rho=None if rho is None else rho.value,
                    interval=None if rho is None else rho.interval_around,
                    more=more.estimate if more else NOTHING,
                )
            )
            p_values.append(np.nan if more is None or measure == PRECISION else more.p)
    return [replace(row, p_holm=p) for row, p in zip(rows, corrected(p_values), strict=True)]


def corrected(p_values: Sequence[float]) -> list[float | None]:
    """P-values after Holm's correction for all that are known; None for NaN.

    Args:
        p_values: One for each row of a table.
    """
    return [None if np.isnan(p) else float(p) for p in holm_adjusted(p_values)]


def _lost(
    figures: Mapping[Condition, Sampled], attacks: Sequence[Condition]
) -> dict[Condition, Sampled]:
    return {attack: figures[attack.unattacked] - figures[attack] for attack in attacks}


def _of_all(measure: str, outcomes: Outcomes, condition: Condition, cases: CaseMeasures) -> Sampled:
    """The measure over all scenarios and intentions, in the samples of `safety`."""
    if measure in PRECISIONS:
        return precision(outcomes, condition, PRECISIONS[measure])
    part, whole = cases[condition][measure].sum(axis=1).T
    return ClusterBootstrap(len(outcomes.scenarios), RESAMPLES).ratio(part, whole)
