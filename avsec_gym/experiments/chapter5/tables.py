"""The thesis' tables, ours: rows of figures with intervals, the thesis' beside them."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from avsec_gym.experiments.chapter5.outcomes import CATEGORY, Condition, Outcomes
from avsec_gym.experiments.chapter5.settings import (
    DETECTORS,
    PATCHES,
    PERTURBATIONS,
    STEPS,
    UNATTACKED,
    specific,
    thesis_setting,
)
from avsec_gym.experiments.json_rows import keyed
from avsec_gym.experiments.thesis import (
    INTENTIONS,
    PRECISION,
    SAFE_DRIVING_WITH_GROUND_TRUTH,
    SAFETY,
    ThesisRates,
)
from avsec_gym.metrics.average_precision import LOW_IOU
from avsec_gym.metrics.many_comparisons import holm_adjusted
from avsec_gym.metrics.paired import PairedRates, paired_differences
from avsec_gym.metrics.safety import SafetyRates, SafetyRecord
from avsec_gym.planners.planner import Algorithm
from avsec_gym.scenario.intention import Intention

PrecisionByMetric = Mapping[str, Mapping[str, Any]]
"""The form of `AveragePrecision.to_json`, of one class."""


@dataclass(frozen=True)
class SafetyRow:
    """A condition and an intention in tables 5.1, 5.2 and 5.4.

    Args:
        condition: The detector under its attack.
        intention: The driving intention.
        rates: The three rates.
        paired: The rates' differences from the unattacked detector; None where that is not there.
        thesis: The thesis' rates, where it has them.
        mcnemar_p_holm: The p-value of `paired` after Holm's correction for all rows of attacks;
            None where there is none.
    """

    condition: Condition
    intention: str
    rates: SafetyRates
    paired: PairedRates | None
    thesis: ThesisRates | None
    mcnemar_p_holm: float | None = None


@dataclass(frozen=True)
class PrecisionRow:
    """A condition in figure 5.3 and table 5.3.

    Args:
        condition: The detector under its attack.
        intention: The driving intention, where detections depend on it.
        labels: Number of cars that count, by level of difficulty.
        ceiling: AP11 and AP40 that perfect detections of them reach, by level, percent.
        precision: Average precision of cars.
        precision_iou_low: The same at the lower IoU.
        thesis: The thesis' average precision by level, as fractions, where it has them.
    """

    condition: Condition
    intention: str | None
    labels: Sequence[int]
    ceiling: Sequence[Sequence[float]]
    precision: PrecisionByMetric
    precision_iou_low: PrecisionByMetric = field(metadata=keyed("precision_iou_0.5"))
    thesis: Sequence[float] | None


@dataclass(frozen=True)
class PlannerRow:
    """A search and an intention in table 5.6: the ground truth is planned on.

    Args:
        planner: The search.
        intention: The driving intention.
        rates: The three rates.
        thesis: The thesis' safe driving rate.
    """

    planner: str
    intention: str
    rates: SafetyRates
    thesis: float


@dataclass(frozen=True)
class InputRow:
    """An input of the planner and an intention in table 5.7.

    Args:
        detector: The detector; None: the ground truth is planned on.
        attack: The attack.
        strength: The attack's strength.
        intention: The driving intention.
        rates: The three rates.
        thesis: The thesis' safe driving rate.
    """

    detector: str | None
    attack: str
    strength: float
    intention: str
    rates: SafetyRates
    thesis: float


@dataclass(frozen=True)
class PlacementRow:
    """Episodes in table 5.5, by where the patch stands.

    Args:
        condition: The detector under its random patch.
        group: ``unattacked``, ``same`` (the patch is where the car intends to go), ``different``
            or ``specific``.
        rates: The three rates.
        thesis: The thesis' rates, where it has them.
    """

    condition: Condition
    group: str
    rates: SafetyRates
    thesis: ThesisRates | None


def safety_rows(outcomes: Outcomes) -> list[SafetyRow]:
    """Tables 5.1, 5.2 and 5.4: the three rates by detector, attack, strength and intention."""
    rows = []
    for condition in outcomes.conditions:
        for intention in Intention:
            records = outcomes.records(condition, intention)
            before = outcomes.records(condition.unattacked, intention)
            key = thesis_setting(condition.attack, condition.strength)
            thesis = SAFETY.get((condition.detector, key, intention))
            rows.append(
                SafetyRow(
                    condition,
                    str(intention),
                    SafetyRates.of(records),
                    paired_differences(before, records),
                    None if condition.whole_levels else thesis,
                )
            )
    corrected = holm_adjusted([_p_of_attack(row) for row in rows])
    return [
        replace(row, mcnemar_p_holm=None if math.isnan(p) else p)
        for row, p in zip(rows, corrected.tolist(), strict=True)
    ]


def _p_of_attack(row: SafetyRow) -> float:
    """McNemar's p; NaN where there is none, and of no attack, which is compared with itself."""
    if row.paired is None or row.condition.attack == UNATTACKED:
        return math.nan
    p = row.paired.mcnemar_p
    return math.nan if p is None else p


def precision_rows(outcomes: Outcomes) -> list[PrecisionRow]:
    """Figure 5.3 and table 5.3: average precision of cars by detector, attack and strength."""
    rows = []
    for condition in outcomes.conditions:
        for intention in outcomes.looks(condition):
            found = outcomes.precision(condition, intention)
            low = outcomes.precision(condition, intention, LOW_IOU, 0).to_json()[CATEGORY]
            attack = condition.attack
            key = thesis_setting(attack, condition.strength)
            if intention is not None:
                key = specific(attack, intention)
            thesis = PRECISION.get((condition.detector, key))
            rows.append(
                PrecisionRow(
                    condition,
                    None if intention is None else str(intention),
                    labels=found.labels[0].tolist(),
                    ceiling=found.ceiling[0].round(4).tolist(),
                    precision=found.to_json()[CATEGORY],
                    precision_iou_low={metric: low[metric] for metric in ("bev", "3d")},
                    thesis=None if condition.whole_levels else thesis,
                )
            )
    return rows


def planner_rows(outcomes: Outcomes) -> list[PlannerRow]:
    """Table 5.6: both searches on the ground truth."""
    rows = [
        PlannerRow(
            str(planner),
            str(intention),
            SafetyRates.of(outcomes.true_records(planner, intention)),
            SAFE_DRIVING_WITH_GROUND_TRUTH[planner, intention],
        )
        for planner in Algorithm
        for intention in Intention
    ]
    return [row for row in rows if row.rates.scenarios]


def input_rows(outcomes: Outcomes) -> list[InputRow]:
    """Table 5.7: the ground truth, the unattacked detectors, and the attacks at their strongest."""
    rows: list[InputRow] = []
    inputs = ((UNATTACKED, 0.0), (PERTURBATIONS[-1], float(STEPS)), (PATCHES[0], 0.0))
    for intention in Intention:
        rates = SafetyRates.of(outcomes.true_records(Algorithm.ASTAR, intention))
        thesis = SAFE_DRIVING_WITH_GROUND_TRUTH[Algorithm.ASTAR, intention]
        rows.append(InputRow(None, UNATTACKED, 0.0, str(intention), rates, thesis))
        for detector in DETECTORS:
            for attack, strength in inputs:
                condition = Condition(detector, attack, strength)
                if condition in outcomes.conditions:
                    thesis = SAFETY[detector, thesis_setting(attack, strength), intention].safe
                    rates = outcomes.rates(condition, intention)
                    rows.append(InputRow(detector, attack, strength, str(intention), rates, thesis))
    return [row for row in rows if row.rates.scenarios]


def placement_rows(outcomes: Outcomes) -> list[PlacementRow]:
    """Table 5.5: the random patch by whether it stands where the car is going to drive."""
    return [
        PlacementRow(
            condition,
            group,
            SafetyRates.of(records),
            INTENTIONS[group] if _has_thesis(condition) else None,
        )
        for condition in outcomes.conditions
        if condition.attack.endswith("-random")
        for group, records in _by_placement(outcomes, condition).items()
    ]


def _by_placement(outcomes: Outcomes, condition: Condition) -> dict[str, list[SafetyRecord]]:
    """The records of each group of table 5.5."""
    aims = {
        row.scenario: list(Intention)[int(row.value)]
        for row in outcomes.results.measurements(name="attack_intention", setting=condition.setting)
    }
    groups: dict[str, list[SafetyRecord]] = defaultdict(list)
    groups["unattacked"] = outcomes.records(condition.unattacked)
    for record in outcomes.records(condition):
        same = aims[record.scenario] == record.intention
        groups["same" if same else "different"].append(record)
    aimed = Condition(condition.detector, condition.attack.replace("-random", "-specific"))
    if aimed in outcomes.conditions:
        groups["specific"] = outcomes.records(aimed)
    return groups


def _has_thesis(condition: Condition) -> bool:
    return (condition.detector, condition.attack) == ("stereo_rcnn", "patch-random")
