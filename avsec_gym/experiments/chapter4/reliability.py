"""How far the fitted probabilities of an attack can be trusted on judged regions."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from avsec_gym.experiments.chapter4.condition_states import ConditionStates
from avsec_gym.experiments.chapter4.settings import ATTACKS, BY_RAYS, METHODS
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.validation.connected.validator import Method

EDGES = (0.0, 0.01, 0.1, 0.5, 0.9, 0.99, 1.0)
"""Probabilities between which regions are counted together."""


@dataclass(frozen=True)
class ReliabilityBin:
    """Regions of similar probability: all of attack-free instants, and those about attacks.

    Args:
        condition: Name of the condition.
        method: The method.
        low: Probability from which on they are.
        high: Probability below which they are, or up to which, of the last ones.
        mean: Mean of their probabilities; None without a region.
        attacked: Those that are about an attack.
    """

    condition: str
    method: Method
    low: float
    high: float
    mean: float | None
    attacked: Share


def reliability(states: ConditionStates) -> list[ReliabilityBin]:
    """The reliability of a condition's probabilities, of regions of which something was heard.

    Args:
        states: All that a run holds of it.
    """
    return [row for method in METHODS for row in _bins(states, method)]


def _bins(states: ConditionStates, method: Method) -> list[ReliabilityBin]:
    judged = [(state, False) for state in states.clean]
    judged += [(state, True) for kind in ATTACKS for state in states.attempts(kind)]
    # What no method compared has no probability that a fit could be right or wrong about.
    cases = [
        (probability, attacked, state.place)
        for state, attacked in judged
        for probability in state.probabilities[method][state.decidable[BY_RAYS]].tolist()
    ]
    rows = []
    for low, high in pairwise(EDGES):
        among = [case for case in cases if low <= case[0] and (case[0] < high or high == EDGES[-1])]
        rows.append(
            ReliabilityBin(
                states.condition.name,
                method,
                low,
                high,
                float(np.mean([probability for probability, _, _ in among])) if among else None,
                share_of([attacked for _, attacked, _ in among], [place for *_, place in among]),
            )
        )
    return rows
