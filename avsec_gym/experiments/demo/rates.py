"""Rates and precision of the demo: a row for each detector and attack."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from statistics import fmean

from avsec_gym.experiments.chapter5.outcomes import CATEGORY, RESAMPLES, Outcomes
from avsec_gym.experiments.chapter5.settings import UNATTACKED
from avsec_gym.experiments.demo.experiment import FULL_REPORT
from avsec_gym.experiments.json_rows import keyed
from avsec_gym.metrics.average_precision import (
    LOW_IOU,
    METRICS,
    STANDARD_IOU,
    AveragePrecision,
)
from avsec_gym.metrics.average_precision_frames import LEVELS
from avsec_gym.metrics.safety import SafetyRates
from avsec_gym.planners.planner import Algorithm
from avsec_gym.scenario.intention import Intention

_MODERATE = LEVELS.index("moderate")


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
        precision_interval: Its 95 % interval, by bootstrap over scenes, low and high; None: there
            are fewer scenes than in a full report.
        precision_iou_low_interval: The same at IoU 0.5.
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
    precision_interval: Sequence[float] | None
    precision_iou_low_interval: Sequence[float] | None = field(
        metadata=keyed("precision_iou_0.5_interval")
    )
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
    no_precision = (None,) * 6
    rows = [DemoRow(None, UNATTACKED, 0.0, False, *no_precision, SafetyRates.of(true))]
    resamples = RESAMPLES if len(outcomes.scenarios) >= FULL_REPORT else 0
    for condition in outcomes.strongest:
        looks = outcomes.looks(condition)
        strict, low = (
            [outcomes.precision(condition, look, iou, resamples) for look in looks]
            for iou in (STANDARD_IOU, LOW_IOU)
        )
        rows.append(
            DemoRow(
                condition.detector,
                condition.attack,
                condition.strength,
                condition.whole_levels,
                precision=fmean(found.value(CATEGORY) for found in strict),
                precision_iou_low=fmean(found.value(CATEGORY) for found in low),
                precision_interval=_interval(strict),
                precision_iou_low_interval=_interval(low),
                precision_ceiling=float(strict[0].ceiling[0, _MODERATE, 0]),
                labels=int(strict[0].labels[0, _MODERATE]),
                rates=outcomes.rates(condition),
            )
        )
    return rows


def _interval(found: Sequence[AveragePrecision]) -> tuple[float, float] | None:
    """The interval of AP11; None without samples, and for a mean over intentions."""
    if len(found) > 1 or found[0].interval is None:
        return None
    low, high = found[0].interval[0, METRICS.index("3d"), _MODERATE, 0].tolist()
    return low, high
