"""Rates and precision of the demo: a row for each detector and attack."""

from __future__ import annotations

from dataclasses import dataclass, field
from statistics import fmean

from avsec_gym.experiments.chapter5.outcomes import CATEGORY, Outcomes
from avsec_gym.experiments.chapter5.settings import UNATTACKED
from avsec_gym.experiments.json_rows import keyed
from avsec_gym.metrics.average_precision import LOW_IOU, STANDARD_IOU
from avsec_gym.metrics.average_precision_frames import LEVELS
from avsec_gym.metrics.safety import SafetyRates
from avsec_gym.planners.planner import Algorithm
from avsec_gym.scenario.intention import Intention


@dataclass(frozen=True)
class DemoRow:
    """What a detector reaches under an attack, the three intentions together.

    Args:
        detector: The detector; None: the ground truth is planned on.
        attack: The attack.
        strength: The attack's strength.
        whole_levels: Whether attacked pixels were rounded.
        precision: Average precision of moderate cars in 3D at IoU 0.7, percent, 11 recall points.
        precision_iou_low: The same at IoU 0.5.
        precision_ceiling: What perfect detections reach.
        labels: Number of labels that count.
        rates: The three rates.
    """

    detector: str | None
    attack: str
    strength: float
    whole_levels: bool
    precision: float | None
    precision_iou_low: float | None = field(metadata=keyed("precision_iou_0.5"))
    precision_ceiling: float | None
    labels: int | None
    rates: SafetyRates


def demo_rows(outcomes: Outcomes) -> list[DemoRow]:
    """A row for each detector and attack, perturbations at their last step only.

    The first row is the planner's on the ground truth.

    Args:
        outcomes: The outcomes of a run.
    """
    true = [
        record
        for intention in Intention
        for record in outcomes.true_records(Algorithm.ASTAR, intention)
    ]
    moderate = LEVELS.index("moderate")
    rows = [DemoRow(None, UNATTACKED, 0.0, False, None, None, None, None, SafetyRates.of(true))]
    for condition in outcomes.strongest:
        looks = outcomes.looks(condition)
        strict, low = (
            fmean(outcomes.precision(condition, look, iou, 0).value(CATEGORY) for look in looks)
            for iou in (STANDARD_IOU, LOW_IOU)
        )
        found = outcomes.precision(condition, looks[0], STANDARD_IOU, 0)
        rows.append(
            DemoRow(
                condition.detector,
                condition.attack,
                condition.strength,
                condition.whole_levels,
                precision=strict,
                precision_iou_low=low,
                precision_ceiling=float(found.ceiling[0, moderate, 0]),
                labels=int(found.labels[0, moderate]),
                rates=outcomes.rates(condition),
            )
        )
    return rows
