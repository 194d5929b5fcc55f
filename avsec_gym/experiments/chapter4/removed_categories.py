"""What was removed, and whether proposals cover it: they are made for cars."""

from __future__ import annotations

from dataclasses import dataclass

from avsec_gym.experiments.chapter4.condition_states import ConditionStates
from avsec_gym.experiments.chapter4.settings import OPERATING_RATE
from avsec_gym.metrics.clustered_shares import Share, share_of


@dataclass(frozen=True)
class RemovedCategory:
    """The removals of objects of one category.

    Args:
        condition: Name of the condition.
        category: KITTI's name.
        covered: Those that a region is about.
        decidable: Those of which another vehicle claims something where the victim has rays.
        detected: Those that the method of rays detects at the held-out threshold at r = 3 %.
    """

    condition: str
    category: str
    covered: Share
    decidable: Share
    detected: Share


def removed_categories(states: ConditionStates) -> list[RemovedCategory]:
    """The categories of a condition, the most frequent first.

    Args:
        states: All that a run holds of it.
    """
    attempts = [(state, state.attack) for state in states.attempts("removal") if state.attack]
    found = [attack.category for _, attack in attempts]
    threshold = states.threshold("rays", OPERATING_RATE)
    rows = []
    for category in sorted(set(found), key=lambda each: (-found.count(each), each)):
        among = [(state, attack) for state, attack in attempts if attack.category == category]
        places = [state.place for state, _ in among]
        rows.append(
            RemovedCategory(
                states.condition.name,
                category,
                share_of([state.covered for state, _ in among], places),
                share_of([attack.witnesses > 0 for _, attack in among], places),
                share_of([state.highest("rays") > threshold for state, _ in among], places),
            )
        )
    return rows
