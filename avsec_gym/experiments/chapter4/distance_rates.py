"""Detection over the distance of an attack from its victim."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

from avsec_gym.experiments.chapter4.condition_states import ConditionStates
from avsec_gym.experiments.chapter4.settings import ATTACKS, METHODS, OPERATING_RATE
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.validation.connected.result import AttackKind

EDGES = (0.0, 10.0, 20.0, 30.0, 40.0)
"""Metres: a ghost stands 6 to 40 m from its victim, and what is removed at most 40 m."""


@dataclass(frozen=True)
class DistanceRate:
    """Attacks of a kind at some distances.

    Args:
        condition: Name of the condition.
        kind: What was attacked.
        nearest: Distance from which on these attacks are from their victims, metres.
        farthest: Distance below which they are, or up to which, of the last ones, metres.
        covered: Those of all of them that a region is about.
        decidable: Those of all of them that some other vehicle's rays reach.
        detected: Those of the decidable ones with a region that exceed the held-out threshold at
            r = 3 %, by method.
    """

    condition: str
    kind: AttackKind
    nearest: float
    farthest: float
    covered: Share
    decidable: Share
    detected: Mapping[str, Share]


def distance_rates(states: ConditionStates) -> list[DistanceRate]:
    """The rates of a condition.

    Args:
        states: All that a run holds of it.
    """
    return [
        _rate(states, kind, nearest, farthest)
        for kind in ATTACKS
        for nearest, farthest in pairwise(EDGES)
    ]


def _rate(
    states: ConditionStates, kind: AttackKind, nearest: float, farthest: float
) -> DistanceRate:
    among = [
        (state, state.attack)
        for state in states.attempts(kind)
        if state.attack is not None
        and nearest <= state.attack.distance
        and (state.attack.distance < farthest or farthest == EDGES[-1])
    ]
    places = [state.place for state, _ in among]
    decided = [state for state, _ in among if state.is_decidable()]
    thresholds = {method: states.threshold(method, OPERATING_RATE) for method in METHODS}
    return DistanceRate(
        states.condition.name,
        kind,
        nearest,
        farthest,
        share_of([state.covered for state, _ in among], places),
        share_of([attack.witnesses > 0 for _, attack in among], places),
        {
            method: share_of(
                [state.highest(method) > threshold for state in decided],
                [state.place for state in decided],
            )
            for method, threshold in thresholds.items()
        },
    )
