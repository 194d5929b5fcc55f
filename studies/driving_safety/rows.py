"""The result of `report` as typed rows, read from its JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from avsec_gym.metrics.paired import with_corrected_p
from avsec_gym.planners.planner import Algorithm
from avsec_gym.scenario.intention import Intention

Json = Mapping[str, Any]


@dataclass(frozen=True)
class Rate:
    """A rate, or a difference of two, with its 95 % interval; None: there was no case."""

    value: float | None
    interval: tuple[float, float] | None

    @classmethod
    def of(cls, row: Json, name: str) -> Rate:
        """The rate of that name in a row as JSON has it."""
        return cls(row[name], row[f"{name}_interval"])


@dataclass(frozen=True)
class RatesRow:
    """One intention, driven by one planner in a set of scenarios.

    Args:
        planner: Search algorithm of the planner.
        intention: The driving intention.
        scenarios: Number of scenarios.
        planned: Number of those with a plan.
        collisions: Number of plans that touch something at a time step.
        swept_collisions: Number of plans that touch something at or between time steps.
        success: Planned of all.
        collision: Collisions of planned.
        safe_driving: Planned without a collision, of all.
        swept_collision: Swept collisions of planned.
        failures: Scenarios without a plan, by reason.
        mean_travel_time: Time to the goal over planned scenarios, s.
        mean_path_length: Length of the path over planned scenarios, m.
        mean_sm1_cost: CommonRoad's cost SM1 over planned scenarios.
    """

    planner: Algorithm
    intention: Intention
    scenarios: int
    planned: int
    collisions: int
    swept_collisions: int
    success: Rate
    collision: Rate
    safe_driving: Rate
    swept_collision: Rate
    failures: Mapping[str, int]
    mean_travel_time: float
    mean_path_length: float
    mean_sm1_cost: float

    @classmethod
    def of(cls, row: Json) -> RatesRow:
        """The row as JSON has it."""
        return cls(
            planner=Algorithm(row["planner"]),
            intention=Intention(row["intention"]),
            success=Rate.of(row, "success_rate"),
            collision=Rate.of(row, "collision_rate"),
            safe_driving=Rate.of(row, "safe_driving_rate"),
            swept_collision=Rate.of(row, "swept_collision_rate"),
            **{name: row[name] for name in _COPIED},
        )


_COPIED = (
    "scenarios", "planned", "collisions", "swept_collisions", "failures", "mean_travel_time",
    "mean_path_length", "mean_sm1_cost",
)  # fmt: skip


@dataclass(frozen=True)
class DifferenceRow:
    """Detections against the ground truth on the same scenarios.

    Args:
        planner: Search algorithm of the planner.
        intention: The driving intention, or all of them.
        success: Difference of the success rates.
        collision: Difference of the collision rates.
        safe_driving: Difference of the safe driving rates.
        became_unsafe: Number of scenarios that are safe by the ground truth only.
        became_safe: Number of scenarios that are safe by the detections only.
        mcnemar_p_holm: McNemar's p for these two numbers after Holm's correction for all rows;
            None: there is none.
    """

    planner: Algorithm
    intention: str
    success: Rate
    collision: Rate
    safe_driving: Rate
    became_unsafe: int
    became_safe: int
    mcnemar_p_holm: float | None

    @classmethod
    def of(cls, row: Json) -> DifferenceRow:
        """The row as JSON has it."""
        return cls(
            planner=Algorithm(row["planner"]),
            intention=row["intention"],
            success=Rate.of(row, "success_rate"),
            collision=Rate.of(row, "collision_rate"),
            safe_driving=Rate.of(row, "safe_driving_rate"),
            became_unsafe=row["became_unsafe"],
            became_safe=row["became_safe"],
            mcnemar_p_holm=row["mcnemar_p_holm"],
        )


@dataclass(frozen=True)
class FlipsRow:
    """Scenarios that detections made unsafe: with a collision, or without a plan."""

    intention: str
    became_unsafe: int
    collisions: int
    no_plan: int


@dataclass(frozen=True)
class DrivingSafetyResults:
    """All that `report` measured; fields are named as in the JSON.

    ``speeds_of_others`` are by the seed of these speeds, ``other_planners`` by the planner in
    words, ``sweep`` by the least score of detections.
    """

    scenarios: int
    detector: str
    score_threshold: float
    ground_truth: Sequence[RatesRow]
    without_scenes_without_cars: Sequence[RatesRow]
    groups: Mapping[str, Sequence[RatesRow]]
    motion_unknown: Sequence[RatesRow]
    drawn_start_speeds: Sequence[RatesRow]
    speeds_of_others: Mapping[int, Sequence[RatesRow]]
    other_planners: Mapping[str, Sequence[RatesRow]]
    detections: Sequence[RatesRow]
    detections_motion_known: Sequence[RatesRow]
    sweep: Mapping[float, Sequence[RatesRow]]
    differences: Sequence[DifferenceRow]
    flips: Sequence[FlipsRow]
    remarks: Sequence[str]

    @classmethod
    def of(cls, results: Json) -> DrivingSafetyResults:
        """The rows of a result as JSON has it."""

        def rates(name: str) -> list[RatesRow]:
            return [RatesRow.of(row) for row in results[name]]

        return cls(
            scenarios=results["scenarios"],
            detector=results["detector"],
            score_threshold=results["score_threshold"],
            ground_truth=rates("ground_truth"),
            without_scenes_without_cars=rates("without_scenes_without_cars"),
            groups={
                group: [RatesRow.of(row) for row in rows]
                for group, rows in results["groups"].items()
            },
            motion_unknown=rates("motion_unknown"),
            drawn_start_speeds=rates("drawn_start_speeds"),
            speeds_of_others=_grouped(results["speeds_of_others"], "seed"),
            other_planners=_grouped(results["other_planners"], "variant"),
            detections=rates("detections"),
            detections_motion_known=rates("detections_motion_known"),
            sweep=_grouped(results["sweep"], "score_threshold"),
            differences=[DifferenceRow.of(row) for row in with_corrected_p(results["differences"])],
            flips=[FlipsRow(**row) for row in results["flips"]],
            remarks=results["remarks"],
        )


def _grouped(rows: Sequence[Json], key: str) -> dict[Any, list[RatesRow]]:
    """The rows by one of their values, in the order in which these come."""
    found: dict[Any, list[RatesRow]] = {}
    for row in rows:
        found.setdefault(row[key], []).append(RatesRow.of(row))
    return found
