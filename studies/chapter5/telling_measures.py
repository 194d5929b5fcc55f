"""Which measure of perception predicts driving safety?

Average precision counts cars that no drive comes near, and wants boxes that fit closely.  Measures
of the cars in reach, which forgive a box that stands a little aside, are compared with safety in
the same way.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from avsec_gym.experiments.chapter5.decoupling import spearman
from avsec_gym.experiments.chapter5.losses import TRUE_ATTACKS, Sampled, precision, safety
from avsec_gym.experiments.chapter5.outcomes import RESAMPLES, Condition, Outcomes
from avsec_gym.experiments.chapter5.rows import NOTHING, Estimate
from avsec_gym.experiments.chapter5.seen import found_cars
from avsec_gym.kitti.detections import above
from avsec_gym.metrics.average_precision import LOW_IOU
from avsec_gym.metrics.average_precision_curves import draw_resamples
from studies.chapter5.corrected_episodes import SAME

IN_REACH = 20.0
"""Metres from the camera: goals are 15 m ahead."""
PRECISION = "AP, IoU 0.7"

Measure = Callable[[Outcomes, Condition, float], Sampled]


@dataclass(frozen=True)
class MeasureRow:
    """How far the loss of a measure goes with the loss of safety.

    Args:
        measure: One of `MEASURES`.
        detector: The detector, or ``both``.
        attacks: Number of attacks.
        rho: Spearman's rank correlation.
        interval: 95 % interval of `rho`, by bootstrap over scenarios; both losses from one draw.
        more: How much larger it is than that of the average precision.
    """

    measure: str
    detector: str
    attacks: int
    rho: float | None
    interval: Sequence[float] | None
    more: Estimate


def telling_rows(outcomes: Outcomes, threshold: float) -> list[MeasureRow]:
    """How far the loss of each measure goes with the loss of safety, over the attacks.

    Args:
        outcomes: The outcomes of a run.
        threshold: The least score of a box that is planned on; others count in precision only.

    Returns:
        A row for each measure and detector, and for ``both``.
    """
    attacks = [
        condition
        for condition in outcomes.conditions
        if condition.attack in TRUE_ATTACKS
        and not condition.whole_levels
        and condition.unattacked in outcomes.conditions
    ]
    safe = _lost(lambda _, one, __: safety(outcomes, one), outcomes, attacks, threshold)
    groups = {
        detector: [attack for attack in attacks if attack.detector == detector]
        for detector in outcomes.detectors
    }
    rows: list[MeasureRow] = []
    usual: dict[str, Sampled | None] = {}
    for measure, of in MEASURES.items():
        lost = _lost(of, outcomes, attacks, threshold)
        for name, group in {**groups, "both": attacks}.items():
            rho = spearman([(lost[attack], safe[attack]) for attack in group])
            first = usual.setdefault(name, rho)
            more = None if rho is None or first is None else rho - first
            rows.append(
                MeasureRow(
                    measure,
                    name,
                    len(group),
                    rho=None if rho is None else rho.value,
                    interval=None if rho is None else rho.interval_around,
                    more=more.estimate if more else NOTHING,
                )
            )
    return rows


def _lost(
    measure: Measure, outcomes: Outcomes, attacks: list[Condition], threshold: float
) -> Mapping[Condition, Sampled]:
    clean = {
        condition: measure(outcomes, condition, threshold)
        for condition in dict.fromkeys(attack.unattacked for attack in attacks)
    }
    return {
        attack: clean[attack.unattacked] - measure(outcomes, attack, threshold)
        for attack in attacks
    }


def _cars_seen(
    outcomes: Outcomes,
    condition: Condition,
    threshold: float,
    reach: float = np.inf,
) -> Sampled:
    """Share of the cars in reach that a box means, percent."""
    counts = np.zeros((len(outcomes.scenarios), 2))
    for intention in outcomes.looks(condition):
        seen = outcomes.detections(condition, intention)
        for number, (scenario, boxes) in enumerate(zip(outcomes.scenarios, seen, strict=True)):
            truth = outcomes.labels[scenario]
            near = np.hypot(truth.location[:, 0], truth.location[:, 2]) < reach
            seen_there = found_cars(above(boxes, threshold), truth[near], SAME)
            counts[number] += seen_there.sum(), len(seen_there)
    samples = draw_resamples(len(outcomes.scenarios), RESAMPLES, 0)
    found, cars_there = counts.T
    with np.errstate(invalid="ignore"):
        return Sampled(
            100 * float(found.sum() / cars_there.sum()),
            100 * (samples @ found) / (samples @ cars_there),
        )


MEASURES: Mapping[str, Measure] = {
    PRECISION: lambda outcomes, one, _: precision(outcomes, one),
    "AP, IoU 0.5": lambda outcomes, one, _: precision(outcomes, one, LOW_IOU),
    "cars found": _cars_seen,
    "cars in reach found": partial(_cars_seen, reach=IN_REACH),
}
"""The usual one first; the last two count cars that a box overlaps by more than `SAME`."""
