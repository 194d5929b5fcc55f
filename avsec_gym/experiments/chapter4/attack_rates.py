"""What becomes of all attacks, end to end: proposed, decidable, detected."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from avsec_gym.experiments.chapter4.condition_states import ConditionStates
from avsec_gym.experiments.chapter4.measured_state import MeasuredState
from avsec_gym.experiments.chapter4.settings import ATTACKS, BY_RAYS, METHODS, OPERATING_RATE
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.validation.connected.result import AttackKind
from avsec_gym.validation.connected.validator import Method


@dataclass(frozen=True)
class AttackRates:
    """Shares of all attacks of a kind, where an attack without a proposed region is a miss.

    Args:
        condition: Name of the condition.
        kind: What was attacked.
        method: The method.
        covered: The attacks that some merged region is about.
        decidable: The attacks that some other vehicle's rays reach, covered or not.
        decidable_by_rays: The attacks with a region of which the method of rays itself has received
            counts enough.
        detected: The attacks with a decidable region above the held-out threshold at r = 3 %.
        of_decidable: The same of the decidable ones, covered or not.
        of_regions: The same of the decidable ones that a region is about.
    """

    condition: str
    kind: AttackKind
    method: Method
    covered: Share
    decidable: Share
    decidable_by_rays: Share
    detected: Share
    of_decidable: Share
    of_regions: Share


def attack_rates(states: ConditionStates) -> list[AttackRates]:
    """The rates of a condition.

    Args:
        states: All that a run holds of it.
    """
    return [_rates(states, kind, method) for kind in ATTACKS for method in METHODS]


def _rates(states: ConditionStates, kind: AttackKind, method: Method) -> AttackRates:
    attempts = states.attempts(kind)
    reached = [state.attack is not None and state.attack.witnesses > 0 for state in attempts]
    threshold = states.threshold(method, OPERATING_RATE)

    def detected(among: Sequence[MeasuredState]) -> Share:
        return _share(among, [state.highest(method) > threshold for state in among])

    return AttackRates(
        states.condition.name,
        kind,
        method,
        covered=_share(attempts, [state.covered for state in attempts]),
        decidable=_share(attempts, reached),
        decidable_by_rays=_share(attempts, [state.is_decidable(BY_RAYS) for state in attempts]),
        detected=detected(attempts),
        of_decidable=detected(
            [state for state, some in zip(attempts, reached, strict=True) if some]
        ),
        of_regions=detected(states.decidable_attacks(kind)),
    )


def _share(states: Sequence[MeasuredState], hits: Sequence[bool]) -> Share:
    return share_of(hits, [state.place for state in states])
