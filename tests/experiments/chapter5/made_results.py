"""Results made by hand: what was seen and what became of episodes, scenario by scenario.

A module of its own, not a test (see conftest.py).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter5.outcomes import Condition, Outcomes
from avsec_gym.experiments.chapter5.settings import setting, specific
from avsec_gym.metrics.safety import SafetyRecord
from avsec_gym.runs.experiment import Measurement
from avsec_gym.scenario.intention import Intention
from avsec_gym.world.layouts.view import observation_angle, project_boxes

NAN = math.nan


def car(x: float = 0.0, z: float = 15.0, score: float = 1.0) -> Boxes3D:
    """One car, easy to see."""
    location, size = np.array([[x, 1.65, z]]), np.array([[1.5, 1.65, 4.0]])
    rotation = np.array([-np.pi / 2])
    return Boxes3D(
        location, size, rotation, np.array([score]), np.array(["Car"]),
        box2d=project_boxes(location, size, rotation).box2d, truncation=np.zeros(1),
        occlusion=np.zeros(1), alpha=observation_angle(location, rotation),
    )  # fmt: skip


def boxes(*parts: Boxes3D) -> Boxes3D:
    return Boxes3D.concatenate(parts) if parts else car()[:0]


def record(
    scenario: str, intention: str, outcome: str = "safe", reason: str | None = None
) -> SafetyRecord:
    planned = outcome != "unplanned"
    return SafetyRecord(
        scenario, intention, outcome, 1.5 if planned else NAN, 3, 12.0 if planned else NAN,
        1.5 if planned else NAN, reason, NAN if planned else 2.0,
        1.0 if outcome == "collision" else NAN, 0 if outcome == "collision" else None,
    )  # fmt: skip


class MadeResults:
    """`Results` in memory."""

    def __init__(self) -> None:
        self.episodes: dict[tuple[str, float, str], list[SafetyRecord]] = {}
        self.seen: dict[tuple[str, float], dict[str, Boxes3D]] = {}
        self.numbers: list[Measurement] = []

    def settings(self) -> list[tuple[str, float]]:
        return sorted({key[:2] for key in self.episodes} | set(self.seen))

    def records(self, **where: Any) -> list[SafetyRecord]:
        way = where.get("intention")
        found = [
            record
            for (name, strength, planner), records in self.episodes.items()
            if where.get("setting", name) == name
            and where.get("strength", strength) == strength
            and where.get("planner", planner) == planner
            for record in records
            if way in (None, record.intention)
        ]
        return sorted(found, key=lambda one: (one.scenario, one.intention))

    def detections(self, setting: str, strength: float = 0.0) -> dict[str, Boxes3D]:
        return self.seen.get((setting, strength), {})

    def measurements(self, **where: Any) -> list[Measurement]:
        return [
            row
            for row in self.numbers
            if all(getattr(row, key) == value for key, value in where.items())
        ]

    def measure(self, condition: Condition, name: str, values: Mapping[str, float]) -> None:
        self.numbers += [
            Measurement(condition.setting, scenario, name, value, condition.strength)
            for scenario, value in values.items()
        ]

    def add(
        self,
        condition: Condition,
        scenarios: Sequence[str],
        *,
        lost: Iterable[str] = (),
        unsafe: Iterable[str] = (),
        extra: Boxes3D | None = None,
        outcome: str = "collision",
    ) -> None:
        """A condition in which the car of `scenarios` is seen but in those that are `lost`."""
        gone, hit = set(lost), set(unsafe)
        known = [] if extra is None else [extra]
        seen = {
            scenario: boxes(*([] if scenario in gone else [car(score=0.9)]), *known)
            for scenario in scenarios
        }
        key = (condition.setting, condition.strength)
        if condition.attack.endswith("specific"):
            for way in Intention:
                name = setting(condition.detector, specific(condition.attack, way))
                self.seen[name, condition.strength] = seen
        else:
            self.seen[key] = seen
        self.episodes[*key, "astar"] = [
            record(scenario, way, outcome if scenario in hit else "safe", "unreachable")
            for scenario in scenarios
            for way in Intention
        ]


def outcomes(results: MadeResults, scenarios: Sequence[str]) -> Outcomes:
    return Outcomes(results, {scenario: car() for scenario in scenarios})


def names(count: int) -> list[str]:
    return [f"{number:06d}" for number in range(count)]
