"""How much a vehicle sends at an instant."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from avsec_gym.experiments.chapter4.condition_states import ConditionStates
from avsec_gym.experiments.chapter4.settings import METHODS
from avsec_gym.validation.connected.validator import Method


@dataclass(frozen=True)
class SentBytes:
    """What vehicles send at attack-free instants, proposals among it.

    Args:
        condition: Name of the condition.
        method: The method.
        mean: Mean of vehicles and instants, bytes.
        most: The most that one vehicle sent at one instant, bytes.
    """

    condition: str
    method: Method
    mean: float
    most: int


def sent_bytes(states: ConditionStates) -> list[SentBytes]:
    """The bytes of a condition.

    Args:
        states: All that a run holds of it.
    """
    rows = []
    for method in METHODS:
        sent = np.concatenate([state.nbytes[method] for state in states.clean])
        rows.append(SentBytes(states.condition.name, method, float(sent.mean()), int(sent.max())))
    return rows
