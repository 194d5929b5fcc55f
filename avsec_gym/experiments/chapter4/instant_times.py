"""How long an instant takes after the proposals, of all vehicles on one core together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from avsec_gym.experiments.chapter4.condition_states import ConditionStates
from avsec_gym.experiments.chapter4.measured_state import MeasuredState
from avsec_gym.experiments.chapter4.settings import ATTACKS, CLEAN, METHODS, State
from avsec_gym.validation.connected.validator import Method


@dataclass(frozen=True)
class InstantTime:
    """CPU time of all steps after the proposals, of all vehicles and the base station.

    Args:
        condition: Name of the condition.
        state: Whether, and how, a vehicle was attacked.
        method: The method.
        median: Median of the instants, seconds.
        largest: The most that one took, seconds.
        of_region: Seconds for a region, over all instants; None of attacked ones, of which only the
            regions about what was attacked are kept.
        regions: Mean number of regions of an instant; None likewise.
        instants: Number of instants.
    """

    condition: str
    state: State
    method: Method
    median: float
    largest: float
    of_region: float | None
    regions: float | None
    instants: int


def instant_times(states: ConditionStates) -> list[InstantTime]:
    """The times of a condition; nothing of a state that no instant was in.

    Args:
        states: All that a run holds of it.
    """
    by_state: dict[State, Sequence[MeasuredState]] = {CLEAN: states.clean}
    by_state |= {kind: states.attempts(kind) for kind in ATTACKS}
    rows = []
    for state, measured in by_state.items():
        regions = sum(each.regions for each in measured) if state == CLEAN else 0
        for method in METHODS:
            seconds = [each.seconds[method] for each in measured]
            if seconds:
                rows.append(
                    InstantTime(
                        states.condition.name,
                        state,
                        method,
                        float(np.median(seconds)),
                        max(seconds),
                        sum(seconds) / regions if regions else None,
                        regions / len(seconds) if regions else None,
                        len(seconds),
                    )
                )
    return rows
