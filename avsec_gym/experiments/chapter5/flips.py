"""Which drives went from safe to unsafe under an attack, and why."""

from __future__ import annotations

from collections import Counter
from typing import Any

from avsec_gym.experiments.chapter5.outcomes import Condition, Outcomes
from avsec_gym.experiments.chapter5.settings import UNATTACKED
from avsec_gym.metrics.safety import SafetyRecord


def flips(outcomes: Outcomes) -> list[dict[str, Any]]:
    """Every drive that the detector does safely unattacked and not under an attack."""
    rows = []
    for condition in outcomes.conditions:
        if condition.attack == UNATTACKED or condition.unattacked not in outcomes.conditions:
            continue
        before = outcomes.records(condition.unattacked)
        for clean, attacked in zip(before, outcomes.records(condition), strict=True):
            if clean.safe and not attacked.safe:
                rows.append(
                    {
                        "detector": condition.detector,
                        "attack": condition.attack,
                        "strength": condition.strength,
                        "whole_levels": condition.whole_levels,
                        "scenario": attacked.scenario,
                        "intention": attacked.intention,
                        "why": why(attacked),
                        "collision_time": attacked.collision_time if attacked.collision else None,
                    }
                )
    return rows


def why(record: SafetyRecord) -> str:
    """In words: something real is hit that was not believed, or nothing could be planned."""
    if record.collision:
        return f"hits object {record.collision_object}"
    if record.goal_occupied > 0:
        return "goal occupied by what is believed"
    return f"no way found ({record.reason})"


def flip_counts(outcomes: Outcomes) -> dict[Condition, Counter[str]]:
    """Of each attack: collisions, and plans that were not found."""
    result: dict[Condition, Counter[str]] = {}
    for row in flips(outcomes):
        condition = Condition(row["detector"], row["attack"], row["strength"], row["whole_levels"])
        kind = "collision" if row["collision_time"] is not None else "unplanned"
        result.setdefault(condition, Counter())[kind] += 1
    return result
