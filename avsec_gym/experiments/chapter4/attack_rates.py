"""What becomes of all attacks, end to end: proposed, decidable, detected, the victim named."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from avsec_gym.experiments.chapter4.condition_states import ConditionStates
from avsec_gym.experiments.chapter4.measured_state import MeasuredState
from avsec_gym.experiments.chapter4.settings import ATTACKS, METHODS, OPERATING_RATE
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.validation.connected.result import AttackKind, Naming
from avsec_gym.validation.connected.validator import Method


@dataclass(frozen=True)
class AttackRates:
    """Shares of all attacks of a kind, where an attack without a proposed region is a miss.

    Args:
        condition: Name of the condition.
        kind: What was attacked.
        method: The method.
        covered: The attacks that some merged region is about.
        decidable: The attacks with a decidable region.
        detected: The attacks with a decidable region above the held-out threshold at r = 3 %.
        of_decidable: The same of the decidable ones.
        victim: The attacks of which the method, at the fit's own threshold, names the victim.
        another: The attacks of which it names another vehicle.
        cannot_tell: The attacks whose vehicle it cannot name, though it alarms.
    """

    condition: str
    kind: AttackKind
    method: Method
    covered: Share
    decidable: Share
    detected: Share
    of_decidable: Share
    victim: Share
    another: Share
    cannot_tell: Share


def attack_rates(states: ConditionStates) -> list[AttackRates]:
    """The rates of a condition.

    Args:
        states: All that a run holds of it.
    """
    return [_rates(states, kind, method) for kind in ATTACKS for method in METHODS]


def _rates(states: ConditionStates, kind: AttackKind, method: Method) -> AttackRates:
    attempts, decidable = states.attempts(kind), states.decidable_attacks(kind)
    threshold = states.threshold(method, OPERATING_RATE)

    def detected(among: Sequence[MeasuredState]) -> Share:
        return _share(among, [state.highest(method) > threshold for state in among])

    def named(naming: Naming) -> Share:
        return _share(attempts, [state.naming(method) == naming for state in attempts])

    return AttackRates(
        states.condition.name,
        kind,
        method,
        covered=_share(attempts, [state.covered for state in attempts]),
        decidable=_share(attempts, [state.is_decidable for state in attempts]),
        detected=detected(attempts),
        of_decidable=detected(decidable),
        victim=named(Naming.VICTIM),
        another=named(Naming.ANOTHER),
        cannot_tell=named(Naming.CANNOT_TELL),
    )


def _share(states: Sequence[MeasuredState], hits: Sequence[bool]) -> Share:
    return share_of(hits, [state.place for state in states])
