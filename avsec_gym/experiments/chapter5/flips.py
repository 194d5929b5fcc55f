"""Which episodes went from safe to unsafe under an attack, and why."""

from __future__ import annotations

from dataclasses import dataclass

from avsec_gym.experiments.chapter5.outcomes import Condition, Outcomes
from avsec_gym.experiments.chapter5.settings import UNATTACKED
from avsec_gym.metrics.safety import SafetyRecord
from avsec_gym.planners.plan import Reason


@dataclass(frozen=True)
class Flip:
    """An episode that is safe unattacked and not under an attack.

    Args:
        condition: The detector under the attack.
        scenario: The scene's id.
        intention: The driving intention.
        outcome: The attacked outcome, ``collision`` or ``unplanned``.
        why: The reason of the flip, in words.
    """

    condition: Condition
    scenario: str
    intention: str
    outcome: str
    why: str


def flips(outcomes: Outcomes) -> list[Flip]:
    """Every episode that is safe with the unattacked detector and not under an attack."""
    rows = []
    for condition in outcomes.conditions:
        if condition.attack == UNATTACKED or condition.unattacked not in outcomes.conditions:
            continue
        before = outcomes.records(condition.unattacked)
        for clean, attacked in zip(before, outcomes.records(condition), strict=True):
            if clean.safe and not attacked.safe:
                place = (attacked.scenario, str(attacked.intention))
                rows.append(Flip(condition, *place, attacked.outcome, why(attacked)))
    return rows


def why(record: SafetyRecord) -> str:
    """The reason in words: something real is hit, or what is believed leaves no way."""
    if record.collision:
        return f"hits a real object after {record.collision_time:.1f} s"
    if record.reason == Reason.START_OCCUPIED:
        return "believes that something stands on it"
    if record.reason == Reason.GOAL_OCCUPIED:
        return f"believes its goal occupied for all {record.goal_occupied:.1f} s"
    if record.reason == Reason.UNREACHABLE:
        return f"finds no way around what it believes, goal occupied {record.goal_occupied:.1f} s"
    return f"finds no plan ({record.reason})"
