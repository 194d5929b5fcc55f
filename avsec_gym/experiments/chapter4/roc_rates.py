"""ROC of all methods over decidable regions, ghosts and removals apart."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from avsec_gym.experiments.chapter4.condition_states import (
    ConditionStates,
    attack_scores,
    region_scores,
)
from avsec_gym.experiments.chapter4.settings import ATTACKS, BY_RAYS, METHODS, RATES
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.metrics.roc_curve import RocArea, roc_area, roc_curve, threshold_at
from avsec_gym.validation.connected.result import AttackKind
from avsec_gym.validation.connected.validator import Method

_MOST_POINTS = 400


@dataclass(frozen=True)
class RocRow:
    """A ROC curve.

    Args:
        condition: Name of the condition.
        kind: What was attacked.
        method: The method.
        attacks: Number of decidable attacks.
        regions: Number of decidable attack-free regions.
        area: The area under the curve.
        true_positives: The attacks detected at the threshold that a share of the judged attack-free
            regions exceeds, by this share: 0.01, 0.03 and 0.1 as texts.
        curve: False and true positive rates, no more than 400 points.
        attacks_by_rays: Number of attacks that are decidable by the counts of the method of rays
            itself.
        area_by_rays: The area under the curve of these and of such attack-free regions.
    """

    condition: str
    kind: AttackKind
    method: Method
    attacks: int
    regions: int
    area: RocArea
    true_positives: Mapping[str, Share]
    curve: Sequence[Sequence[float]]
    attacks_by_rays: int
    area_by_rays: RocArea


def roc_rows(states: ConditionStates) -> list[RocRow]:
    """The curves of a condition.

    Args:
        states: All that a run holds of it.
    """
    return [_row(states, kind, method) for kind in ATTACKS for method in METHODS]


def _row(states: ConditionStates, kind: AttackKind, method: Method) -> RocRow:
    attacked = attack_scores(states.decidable_attacks(kind), method)
    clean = region_scores(states.clean, method)
    rates = {
        str(rate): share_of(attacked.scores > threshold_at(clean.scores, rate), attacked.clusters)
        for rate in RATES
    }
    curve: list[list[float]] = []
    if len(attacked) and len(clean):
        points = np.round(np.stack(roc_curve(attacked.scores, clean.scores), axis=1), 5)
        chosen = np.linspace(0, len(points) - 1, min(len(points), _MOST_POINTS)).astype(int)
        curve = points[chosen].tolist()
    by_rays = attack_scores(states.decidable_attacks(kind, BY_RAYS), method, BY_RAYS)
    return RocRow(
        states.condition.name,
        kind,
        method,
        len(attacked),
        len(clean),
        roc_area(attacked, clean),
        rates,
        curve,
        len(by_rays),
        roc_area(by_rays, region_scores(states.clean, method, BY_RAYS)),
    )
