"""Why: how many cars a detector still finds under an attack, and where it sees ghosts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter5.ghost_positions import (
    in_corridor,
)
from avsec_gym.experiments.chapter5.outcomes import CATEGORY, RESAMPLES, Condition, Outcomes
from avsec_gym.geometry import Floats
from avsec_gym.kitti.detections import above
from avsec_gym.metrics.average_precision_curves import draw_resamples
from avsec_gym.metrics.estimate import Estimate
from avsec_gym.metrics.ghosts import ghosts, iou_from_above

MIN_OVERLAP = 0.5
"""Intersection over union from above with which a car counts as found."""
_LOW_AND_HIGH = (0.025, 0.975)


@dataclass(frozen=True)
class SeenRow:
    """What a detector still sees under an attack.

    Args:
        condition: The detector under the attack.
        cars_found: Share of the labelled cars that are found.
        ghosts_in_lanes: Ghosts in the lanes that may be driven on, for each scenario.
        ghosts_beside: Ghosts beside these lanes, for each scenario.
    """

    condition: Condition
    cars_found: Estimate
    ghosts_in_lanes: Estimate
    ghosts_beside: Estimate


def seen_rows(outcomes: Outcomes, threshold: float) -> list[SeenRow]:
    """Cars found, ghosts in the lanes that may be driven on, ghosts beside them; per scenario.

    Perturbations have a row for their last step only.  Intervals hold 95 % of a bootstrap over
    scenarios.

    Args:
        outcomes: The outcomes of a run.
        threshold: The least score of a detection that is planned on; others do not count.
    """
    rows = []
    samples = draw_resamples(len(outcomes.scenarios), RESAMPLES, 0)
    for condition in outcomes.strongest:
        found, cars, within, beside, looks = _counts(outcomes, condition, threshold).T
        rows.append(
            SeenRow(
                condition,
                cars_found=_ratio(found, cars, samples),
                ghosts_in_lanes=_ratio(within, looks, samples),
                ghosts_beside=_ratio(beside, looks, samples),
            )
        )
    return rows


def found_cars(
    detections: Boxes3D, truth: Boxes3D, overlap: float = MIN_OVERLAP
) -> NDArray[np.bool_]:
    """Which labelled cars a detection lies on, seen from above, shape (number of cars,)."""
    cars = truth[truth.category == CATEGORY]
    iou = iou_from_above(cars, detections)
    result: NDArray[np.bool_] = iou.max(axis=1, initial=0.0) > overlap
    return result


def _counts(outcomes: Outcomes, condition: Condition, threshold: float) -> Floats:
    """Cars found, cars, ghosts in lanes, ghosts beside, looks; of each scenario, shape (S, 5)."""
    total = np.zeros((len(outcomes.scenarios), 5))
    for intention in outcomes.looks(condition):
        seen = outcomes.detections(condition, intention)
        total += [
            _count(above(boxes, threshold), outcomes.labels[scenario])
            for scenario, boxes in zip(outcomes.scenarios, seen, strict=True)
        ]
    return total


def _ratio(part: Floats, whole: Floats, samples: NDArray[np.int64]) -> Estimate:
    """The ratio of two sums over scenarios, shape (S,) each, and of those of each sample."""
    with np.errstate(invalid="ignore", divide="ignore"):
        value, drawn = part.sum() / whole.sum(), (samples @ part) / (samples @ whole)
    drawn = drawn[np.isfinite(drawn)]
    return Estimate(
        float(value) if np.isfinite(value) else None,
        [float(q) for q in np.quantile(drawn, _LOW_AND_HIGH)] if len(drawn) else None,
    )


def _count(detections: Boxes3D, truth: Boxes3D) -> tuple[int, int, int, int, int]:
    found = found_cars(detections, truth)
    unreal = detections[ghosts(detections, truth)]
    within = in_corridor(unreal)
    return int(found.sum()), len(found), int(within.sum()), int((~within).sum()), 1
