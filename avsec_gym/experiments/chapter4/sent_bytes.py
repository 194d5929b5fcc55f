"""How much vehicles and the base station send at an instant."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from avsec_gym.experiments.chapter4.condition_states import ConditionStates
from avsec_gym.experiments.chapter4.settings import METHODS
from avsec_gym.geometry import Floats
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


@dataclass(frozen=True)
class KindBytes:
    """What one sender sends of one kind of message at attack-free instants.

    Args:
        condition: Name of the condition.
        sender: ``vehicle``, or ``base station``, which sends to all vehicles at once.
        kind: The kind of message.
        mean: Mean of senders and instants, bytes.
        most: The most of one sender at one instant, bytes.
    """

    condition: str
    sender: str
    kind: str
    mean: float
    most: int


def sent_bytes(states: ConditionStates) -> list[SentBytes]:
    """The bytes of a condition, by method.

    Args:
        states: All that a run holds of it.
    """
    rows = []
    for method in METHODS:
        sent = np.concatenate([state.nbytes(method) for state in states.clean])
        rows.append(SentBytes(states.condition.name, method, float(sent.mean()), int(sent.max())))
    return rows


def bytes_of_kinds(states: ConditionStates) -> list[KindBytes]:
    """The bytes of a condition, by kind of message.

    Args:
        states: All that a run holds of it.
    """
    found: dict[tuple[str, str], list[Floats]] = {}
    for state in states.clean:
        for kind, sent in state.sent.items():
            found.setdefault(("vehicle", str(kind)), []).append(sent.astype(float))
        for kind, nbytes in state.from_station.items():
            found.setdefault(("base station", kind), []).append(np.array([nbytes], float))
    rows = []
    for (sender, kind), each in found.items():
        sent = np.concatenate(each)
        name, mean, most = states.condition.name, float(sent.mean()), int(sent.max())
        rows.append(KindBytes(name, sender, kind, mean, most))
    return rows
