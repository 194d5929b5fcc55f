"""Who is named: the victim of an attack, another vehicle, or an honest one anywhere."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from avsec_gym.experiments.chapter4.condition_states import ConditionStates
from avsec_gym.experiments.chapter4.measured_state import MeasuredState
from avsec_gym.experiments.chapter4.settings import (
    ATTACKS,
    BY_GEOMETRY,
    BY_RAYS,
    CLEAN,
    NAMERS,
    DecidedBy,
    Namer,
    State,
)
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.validation.connected.result import AttackKind, Naming

ENOUGH_WITNESSES = 3
"""Witnesses of an attack from whom on it can be expected that the victim is named."""
LEAST_WITNESSES: tuple[tuple[DecidedBy, int], ...] = (
    (BY_GEOMETRY, 0),
    (BY_GEOMETRY, 1),
    (BY_GEOMETRY, ENOUGH_WITNESSES),
    (BY_RAYS, 1),
    (BY_RAYS, ENOUGH_WITNESSES),
)
"""What sets of attacks have at least, by either count: all, the decidable ones, those that several
could tell."""


@dataclass(frozen=True)
class NamingRate:
    """Whom a method names at attacks of a kind, at the thresholds of the fit.

    Args:
        condition: Name of the condition.
        kind: What was attacked.
        namer: The method, or the thesis' own rule, which asks for no two accusers.
        by: What makes a vehicle a witness, the geometry of clean scans or the rays that count under
            all errors.
        witnesses: Number of witnesses that the attacks have at least; with 1 or more, only those
            that a region is about.
        victim: The attacks of which it names the victim.
        another: The attacks of which it names another vehicle.
        cannot_tell: The attacks whose vehicle it cannot name, though it alarms.
    """

    condition: str
    kind: AttackKind
    namer: Namer
    by: DecidedBy
    witnesses: int
    victim: Share
    another: Share
    cannot_tell: Share


@dataclass(frozen=True)
class HonestNamed:
    """How often a vehicle that is not attacked is named, in whatever region.

    Args:
        condition: Name of the condition.
        state: Whether, and how, another vehicle was attacked.
        namer: The method, or the thesis' own rule.
        instants: The instants with an honest vehicle named in some region.
    """

    condition: str
    state: State
    namer: Namer
    instants: Share


def naming_rates(states: ConditionStates) -> list[NamingRate]:
    """Who is named under a condition.

    Args:
        states: All that a run holds of it.
    """
    return [
        _rate(states, kind, namer, by, witnesses)
        for kind in ATTACKS
        for namer in NAMERS
        for by, witnesses in LEAST_WITNESSES
    ]


def honest_named(states: ConditionStates) -> list[HonestNamed]:
    """How often honest vehicles are named under a condition.

    Args:
        states: All that a run holds of it.
    """
    by_state: dict[State, Sequence[MeasuredState]] = {CLEAN: states.clean}
    by_state |= {kind: states.attempts(kind) for kind in ATTACKS}
    return [
        HonestNamed(
            states.condition.name,
            state,
            namer,
            share_of([each.honest[namer] > 0 for each in measured], _places(measured)),
        )
        for state, measured in by_state.items()
        for namer in NAMERS
    ]


def _rate(
    states: ConditionStates, kind: AttackKind, namer: Namer, by: DecidedBy, witnesses: int
) -> NamingRate:
    among = [
        state
        for state in states.attempts(kind)
        if state.witnesses(by) >= witnesses and (state.covered or not witnesses)
    ]

    def named(naming: Naming) -> Share:
        return share_of([state.naming(namer) == naming for state in among], _places(among))

    return NamingRate(
        states.condition.name,
        kind,
        namer,
        by,
        witnesses,
        victim=named(Naming.VICTIM),
        another=named(Naming.ANOTHER),
        cannot_tell=named(Naming.CANNOT_TELL),
    )


def _places(states: Sequence[MeasuredState]) -> list[str]:
    return [state.place for state in states]
