"""The result of `report` as typed rows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from avsec_gym.experiments.json_rows import FLAT, row_of
from avsec_gym.metrics.paired import PairedRates, holm_p
from avsec_gym.metrics.safety import SafetyRates
from avsec_gym.planners.planner import Algorithm
from avsec_gym.scenario.intention import Intention


@dataclass(frozen=True)
class RatesRow:
    """One intention, driven by one planner in a set of scenarios.

    Args:
        planner: Search algorithm of the planner.
        intention: The driving intention.
        rates: The rates.
    """

    planner: Algorithm
    intention: Intention
    rates: SafetyRates


@dataclass(frozen=True)
class SeedRow:
    """The same where speeds of the moving objects are drawn from another seed."""

    seed: int
    row: RatesRow = field(metadata=FLAT)


@dataclass(frozen=True)
class VariantRow:
    """The same with another planner, in words."""

    variant: str
    row: RatesRow = field(metadata=FLAT)


@dataclass(frozen=True)
class SweepRow:
    """The same with detections of at least a score."""

    score_threshold: float
    row: RatesRow = field(metadata=FLAT)


@dataclass(frozen=True)
class DifferenceRow:
    """Detections against the ground truth on the same scenarios.

    Args:
        planner: Search algorithm of the planner.
        intention: The driving intention, or ``all``.
        paired: Differences of the rates.
        mcnemar_p_holm: McNemar's p after Holm's correction for all rows; None: there is none.
    """

    planner: Algorithm
    intention: str
    paired: PairedRates = field(metadata=FLAT)
    mcnemar_p_holm: float | None


@dataclass(frozen=True)
class FlipsRow:
    """Scenarios that detections made unsafe: with a collision, or without a plan."""

    intention: str
    became_unsafe: int
    collisions: int
    no_plan: int


@dataclass(frozen=True)
class DrivingSafetyResults:
    """All that `report` measured."""

    scenarios: int
    detector: str
    score_threshold: float
    ground_truth: Sequence[RatesRow]
    without_scenes_without_cars: Sequence[RatesRow]
    groups: Mapping[str, Sequence[RatesRow]]
    motion_unknown: Sequence[RatesRow]
    drawn_start_speeds: Sequence[RatesRow]
    speeds_of_others: Sequence[SeedRow]
    other_planners: Sequence[VariantRow]
    detections: Sequence[RatesRow]
    detections_without_scenes_without_cars: Sequence[RatesRow]
    differences: Sequence[DifferenceRow]
    detections_motion_known: Sequence[RatesRow]
    flips: Sequence[FlipsRow]
    sweep: Sequence[SweepRow]
    remarks: Sequence[str]

    @classmethod
    def of(cls, result: Mapping[str, Any]) -> DrivingSafetyResults:
        """The rows of a result as JSON has it; those of earlier releases lack corrected p-values.

        Raises:
            KeyError: A part is missing.
        """
        read = row_of(cls, result)
        corrected = holm_p([row.paired for row in read.differences])
        rows = zip(read.differences, corrected, strict=True)
        return replace(read, differences=[replace(row, mcnemar_p_holm=p) for row, p in rows])
