"""Detection over the designated false positive rate, thresholds held out (figure 4b)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from avsec_gym.experiments.chapter4.condition_states import (
    ConditionStates,
    attack_scores,
    region_scores,
)
from avsec_gym.experiments.chapter4.settings import ATTACKS, CURVE_RATES, METHODS
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.metrics.roc_curve import threshold_at
from avsec_gym.validation.connected.result import AttackKind
from avsec_gym.validation.connected.validator import Method

PAIRS, REGIONS = "pairs", "regions"
"""What r is a share of: distances of pairs, as in the thesis, or regions."""


@dataclass(frozen=True)
class DetectionRate:
    """How many decidable attacks exceed a threshold that attack-free instants of others gave.

    Args:
        condition: Name of the condition.
        kind: What was attacked.
        method: The method.
        of: `PAIRS` or `REGIONS`, whose share r is.
        rate: The designated false positive rate r.
        detected: The decidable attacks that are detected.
        false_alarms: The decidable attack-free regions, of the judged instants, that alarm.
    """

    condition: str
    kind: AttackKind
    method: Method
    of: str
    rate: float
    detected: Share
    false_alarms: Share


def detection_rates(
    states: ConditionStates, rates: Sequence[float] = CURVE_RATES
) -> list[DetectionRate]:
    """Detection rates of a condition: of the thesis' method by both meanings of r.

    Args:
        states: All that a run holds of it.
        rates: The values of r.
    """
    pairs = np.concatenate([np.zeros(0), *(state.distances for state in states.fitted)])
    rows = []
    for method in METHODS:
        regions = region_scores(states.fitted, method).scores
        for of, samples in ((REGIONS, regions), (PAIRS, pairs)):
            if of == PAIRS and method != "surfaces":
                continue
            for rate in rates:
                threshold = threshold_at(samples, rate)
                rows += [_row(states, kind, method, of, rate, threshold) for kind in ATTACKS]
    return rows


def _row(
    states: ConditionStates,
    kind: AttackKind,
    method: Method,
    of: str,
    rate: float,
    threshold: float,
) -> DetectionRate:
    attacked = attack_scores(states.decidable_attacks(kind), method)
    clean = region_scores(states.clean, method)
    return DetectionRate(
        states.condition.name,
        kind,
        method,
        of,
        rate,
        share_of(attacked.scores > threshold, attacked.clusters),
        share_of(clean.scores > threshold, clean.clusters),
    )
