"""Detection over the designated false positive rate, thresholds held out (figure 4b)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from avsec_gym.experiments.chapter4.condition_states import (
    ConditionStates,
    attack_scores,
    region_scores,
)
from avsec_gym.experiments.chapter4.settings import (
    ATTACKS,
    BY_GEOMETRY,
    BY_RAYS,
    CURVE_RATES,
    METHODS,
    DecidedBy,
)
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
        detected_by_rays: The detected ones of the attacks that are decidable by the counts of the
            method of rays itself, at a threshold of such regions.
        false_alarms_by_rays: The attack-free regions, decidable by the same counts, that alarm.
    """

    condition: str
    kind: AttackKind
    method: Method
    of: str
    rate: float
    detected: Share
    false_alarms: Share
    detected_by_rays: Share
    false_alarms_by_rays: Share


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
        for of in (REGIONS, PAIRS) if method == "surfaces" else (REGIONS,):
            for rate in rates:
                thresholds: dict[DecidedBy, float] = {
                    by: threshold_at(pairs, rate)
                    if of == PAIRS
                    else states.threshold(method, rate, by)
                    for by in (BY_GEOMETRY, BY_RAYS)
                }
                rows += [_row(states, kind, method, of, rate, thresholds) for kind in ATTACKS]
    return rows


def _row(
    states: ConditionStates,
    kind: AttackKind,
    method: Method,
    of: str,
    rate: float,
    thresholds: Mapping[DecidedBy, float],
) -> DetectionRate:
    shares = []
    for by, threshold in thresholds.items():
        attacked = attack_scores(states.decidable_attacks(kind, by), method, by)
        clean = region_scores(states.clean, method, by)
        shares += [share_of(each.scores > threshold, each.clusters) for each in (attacked, clean)]
    return DetectionRate(states.condition.name, kind, method, of, rate, *shares)
