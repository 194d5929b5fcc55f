"""The thesis' tables, ours: rows of figures with intervals, the thesis' beside them."""

from __future__ import annotations

from collections import defaultdict
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
from avsec_gym.experiments.thesis import (
    INTENTIONS,
    PRECISION,
    SAFE_DRIVING_WITH_GROUND_TRUTH,
    SAFETY,
    ThesisRates,
)
from avsec_gym.metrics.average_precision import LOW_IOU
from avsec_gym.metrics.paired import paired_differences
from avsec_gym.metrics.safety import SafetyRates, SafetyRecord
from avsec_gym.planners.planner import Algorithm
from avsec_gym.scenario.intention import Intention

Row = dict[str, Any]


def safety_rows(outcomes: Outcomes) -> list[Row]:
    """Tables 5.1, 5.2 and 5.4: the three rates by detector, attack, strength and intention."""
    rows = []
    for condition in outcomes.conditions:
        for intention in Intention:
            records = outcomes.records(condition, intention)
            key = thesis_setting(condition.attack, condition.strength)
            thesis = SAFETY.get((condition.detector, key, intention))
            rows.append(
                {
                    **named(condition),
                    "intention": str(intention),
                    **SafetyRates.of(records).to_json(),
                    "paired": _paired(outcomes, condition, intention),
                    "thesis": _thesis(None if condition.whole_levels else thesis),
                }
            )
    return rows


def precision_rows(outcomes: Outcomes) -> list[Row]:
    """Figure 5.3 and table 5.3: average precision of cars by detector, attack and strength."""
    rows = []
    for condition in outcomes.conditions:
        for intention in outcomes.looks(condition):
            found = outcomes.precision(condition, intention)
            strict = found.to_json()[CATEGORY]
            low = outcomes.precision(condition, intention, LOW_IOU, 0).to_json()[CATEGORY]
            attack = condition.attack
            key = thesis_setting(attack, condition.strength)
            if intention is not None:
                key = specific(attack, intention)
            thesis = PRECISION.get((condition.detector, key))
            rows.append(
                {
                    **named(condition),
                    "intention": None if intention is None else str(intention),
                    "labels": found.labels[0].tolist(),
                    "ceiling": found.ceiling[0].round(4).tolist(),
                    "precision": strict,
                    "precision_iou_0.5": {name: low[name] for name in ("bev", "3d")},
                    "thesis": None if thesis is None or condition.whole_levels else list(thesis),
                }
            )
    return rows


def planner_rows(outcomes: Outcomes) -> list[Row]:
    """Table 5.6: both searches on the ground truth."""
    rows: list[Row] = []
    for planner in Algorithm:
        for intention in Intention:
            records = outcomes.true_records(planner, intention)
            rows.append(
                {
                    "planner": str(planner),
                    "intention": str(intention),
                    **SafetyRates.of(records).to_json(),
                    "thesis": SAFE_DRIVING_WITH_GROUND_TRUTH[planner, intention],
                }
            )
    return [row for row in rows if row["scenarios"]]


def input_rows(outcomes: Outcomes) -> list[Row]:
    """Table 5.7: the ground truth, the unattacked detectors, and the attacks at their strongest."""
    rows: list[Row] = []
    inputs = ((UNATTACKED, 0.0), (PERTURBATIONS[-1], float(STEPS)), (PATCHES[0], 0.0))
    for intention in Intention:
        records = outcomes.true_records(Algorithm.ASTAR, intention)
        thesis = SAFE_DRIVING_WITH_GROUND_TRUTH[Algorithm.ASTAR, intention]
        rows.append(_input_row(None, UNATTACKED, 0.0, intention, records, thesis))
        for detector in DETECTORS:
            for attack, strength in inputs:
                condition = Condition(detector, attack, strength)
                if condition in outcomes.conditions:
                    key = thesis_setting(attack, strength)
                    thesis = SAFETY[detector, key, intention].safe
                    records = outcomes.records(condition, intention)
                    rows.append(_input_row(detector, attack, strength, intention, records, thesis))
    return [row for row in rows if row["scenarios"]]


def _input_row(
    detector: str | None,
    attack: str,
    strength: float,
    intention: Intention,
    records: list[SafetyRecord],
    thesis: float,
) -> Row:
    return {
        "detector": detector,
        "attack": attack,
        "strength": strength,
        "intention": str(intention),
        **SafetyRates.of(records).to_json(),
        "thesis": thesis,
    }


def intention_rows(outcomes: Outcomes) -> list[Row]:
    """Table 5.5: the random patch by whether it stands where the car is going to drive."""
    rows: list[Row] = []
    for condition in outcomes.conditions:
        if not condition.attack.endswith("-random"):
            continue
        aims = {
            row["scenario"]: list(Intention)[int(row["value"])]
            for row in outcomes.results.measurements(
                name="attack_intention", setting=condition.setting
            )
        }
        groups: dict[str, list[SafetyRecord]] = defaultdict(list)
        groups["unattacked"] = outcomes.records(condition.unattacked)
        for record in outcomes.records(condition):
            same = aims[record.scenario] == record.intention
            groups["same" if same else "different"].append(record)
        aimed = Condition(condition.detector, condition.attack.replace("-random", "-specific"))
        if aimed in outcomes.conditions:
            groups["specific"] = outcomes.records(aimed)
        for name, records in groups.items():
            by_thesis = condition.detector == "stereo_rcnn" and condition.attack == "patch-random"
            rows.append(
                {
                    **named(condition),
                    "group": name,
                    **SafetyRates.of(records).to_json(),
                    "thesis": _thesis(INTENTIONS[name] if by_thesis else None),
                }
            )
    return rows


def named(condition: Condition) -> Row:
    """The condition's own columns of a row."""
    return {
        "detector": condition.detector,
        "attack": condition.attack,
        "strength": condition.strength,
        "whole_levels": condition.whole_levels,
    }


def _paired(outcomes: Outcomes, condition: Condition, intention: Intention) -> Row | None:
    before = outcomes.records(condition.unattacked, intention)
    return paired_differences(before, outcomes.records(condition, intention)) if before else None


def _thesis(rates: ThesisRates | None) -> Row | None:
    return None if rates is None else vars(rates)
