"""Why: how many cars a detector still finds under an attack, and where it sees ghosts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter5.ghost_positions import ghosts, in_corridor, iou_from_above
from avsec_gym.experiments.chapter5.outcomes import CATEGORY, RESAMPLES, Condition, Outcomes
from avsec_gym.experiments.chapter5.tables import Row, named
from avsec_gym.geometry import Floats
from avsec_gym.kitti.detections import above
from avsec_gym.metrics.average_precision_curves import draw_resamples

MIN_OVERLAP = 0.5
"""Intersection over union from above with which a car counts as found."""
_LOW_AND_HIGH = (0.025, 0.975)


def seen_rows(outcomes: Outcomes, threshold: float) -> list[Row]:
    """Cars found, ghosts in the lanes that may be driven on, ghosts beside them; per scenario.

    Of perturbations only the strongest are looked at.  Intervals hold 95 % of a bootstrap over
    scenarios.

    Args:
        outcomes: Of a run.
        threshold: Less sure detections are not planned on, and not counted.
    """
    rows = []
    samples = draw_resamples(len(outcomes.scenarios), RESAMPLES, 0)
    for condition in outcomes.strongest:
        counts = _counts(outcomes, condition, threshold)
        row: Row = named(condition)
        for name, part, whole in (
            ("cars_found", counts[:, 0], counts[:, 1]),
            ("ghosts_in_lanes", counts[:, 2], counts[:, 4]),
            ("ghosts_beside", counts[:, 3], counts[:, 4]),
        ):
            with np.errstate(invalid="ignore", divide="ignore"):
                value, drawn = part.sum() / whole.sum(), (samples @ part) / (samples @ whole)
            drawn = drawn[np.isfinite(drawn)]
            row[name] = float(value) if np.isfinite(value) else None
            row[f"{name}_interval"] = (
                [float(q) for q in np.quantile(drawn, _LOW_AND_HIGH)] if len(drawn) else None
            )
        rows.append(row)
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


def _count(detections: Boxes3D, truth: Boxes3D) -> Sequence[Any]:
    found = found_cars(detections, truth)
    unreal = detections[ghosts(detections, truth)]
    within = in_corridor(unreal)
    return found.sum(), len(found), within.sum(), (~within).sum(), 1
