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
from avsec_gym.metrics.cluster_bootstrap import ClusterBootstrap
from avsec_gym.metrics.estimate import Estimate
from avsec_gym.metrics.ghosts import ghosts, iou_from_above

MIN_OVERLAP = 0.5
"""Intersection over union from above with which a car counts as found."""


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
    drawn = ClusterBootstrap(len(outcomes.scenarios), RESAMPLES)
    for condition in outcomes.strongest:
        found, cars, within, beside, looks = _counts(outcomes, condition, threshold).T
        rows.append(
            SeenRow(
                condition,
                cars_found=drawn.ratio(found, cars).estimate,
                ghosts_in_lanes=drawn.ratio(within, looks).estimate,
                ghosts_beside=drawn.ratio(beside, looks).estimate,
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


def _count(detections: Boxes3D, truth: Boxes3D) -> tuple[int, int, int, int, int]:
    found = found_cars(detections, truth)
    unreal = detections[ghosts(detections, truth)]
    within = in_corridor(unreal)
    return int(found.sum()), len(found), int(within.sum()), int((~within).sum()), 1
