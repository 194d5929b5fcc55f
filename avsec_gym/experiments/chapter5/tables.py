"""The thesis' tables, ours: rows of figures with intervals, the thesis' beside them."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from typing import Any

import numpy as np

from avsec_gym.experiments.chapter5.outcomes import CATEGORY, Condition, Outcomes
from avsec_gym.experiments.chapter5.settings import (
    NOISES,
    PERTURBATIONS,
    UNATTACKED,
    setting,
    specific,
    thesis_setting,
)
from avsec_gym.experiments.chapter5.true_drives import GROUND_TRUTH
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
                    **_named(condition),
                    "intention": str(intention),
                    **SafetyRates.of(records).to_json(),
                    "paired": paired_differences(
                        outcomes.records(condition.unattacked, intention), records
                    ),
                    "thesis": _thesis(None if condition.whole_levels else thesis),
                }
            )
    return rows


def precision_rows(outcomes: Outcomes) -> list[Row]:
    """Figure 5.6 and table 5.3: average precision of cars by detector, attack and strength."""
    rows = []
    for condition in outcomes.conditions:
        for intention in outcomes.looks(condition):
            strict = outcomes.precision(condition, intention).to_json()[CATEGORY]
            low = outcomes.precision(condition, intention, LOW_IOU).to_json()[CATEGORY]
            attack = condition.attack
            key = thesis_setting(attack, condition.strength)
            if intention is not None:
                key = specific(attack, intention)
            thesis = PRECISION.get((condition.detector, key))
            rows.append(
                {
                    **_named(condition),
                    "intention": None if intention is None else str(intention),
                    "precision": strict,
                    "precision_iou_0.5": {name: low[name] for name in ("bev", "3d")},
                    "thesis": None if thesis is None or condition.whole_levels else list(thesis),
                }
            )
    return rows


def planner_rows(outcomes: Outcomes) -> list[Row]:
    """Table 5.6: both searches on the ground truth."""
    rows = []
    for planner in Algorithm:
        for intention in Intention:
            records = outcomes.results.records(
                setting=GROUND_TRUTH, planner=str(planner), intention=str(intention)
            )
            rows.append(
                {
                    "planner": str(planner),
                    "intention": str(intention),
                    **SafetyRates.of(records).to_json(),
                    "thesis": SAFE_DRIVING_WITH_GROUND_TRUTH[planner, intention],
                }
            )
    return rows


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
                    **_named(condition),
                    "group": name,
                    **SafetyRates.of(records).to_json(),
                    "thesis": _thesis(INTENTIONS[name] if by_thesis else None),
                }
            )
    return rows


def control_rows(outcomes: Outcomes) -> list[Row]:
    """The sanity sheet: what attacks do to the loss, and how far they change pixels.

    The loss is that to the truth, which perturbations raise, as a median over the scenarios.
    """
    return list(_control_rows(outcomes))


def _control_rows(outcomes: Outcomes) -> Iterator[Row]:
    values: dict[tuple[str, float, str], dict[str, float]] = defaultdict(dict)
    for row in outcomes.results.measurements():
        values[row["setting"], row["strength"], row["name"]][row["scenario"]] = row["value"]
    for condition in outcomes.conditions:
        loss = values.get((condition.setting, condition.strength, "loss"))
        if not loss or condition.attack == UNATTACKED:
            continue
        clean = values[setting(condition.detector, UNATTACKED), 0.0, "loss"]
        both = [name for name in outcomes.scenarios if name in loss and name in clean]
        before, after = (np.array([one[name] for name in both]) for one in (clean, loss))
        change = values[condition.setting, condition.strength, "change"]
        yield {
            **_named(condition),
            "scenarios": len(both),
            "loss_before": float(np.median(before)),
            "loss_after": float(np.median(after)),
            "share_raised": float(np.mean(after > before)),
            "largest_change": max(change[name] for name in both),
            "budget": _budget(condition),
        }


def _budget(condition: Condition) -> float:
    _, _, alpha = condition.attack.partition("-")
    if condition.attack in PERTURBATIONS + NOISES:
        return condition.strength * float(alpha)
    return condition.strength if "pgd" in alpha else 255.0


def _named(condition: Condition) -> Row:
    return {
        "detector": condition.detector,
        "attack": condition.attack,
        "strength": condition.strength,
        "whole_levels": condition.whole_levels,
    }


def _thesis(rates: ThesisRates | None) -> Row | None:
    return None if rates is None else vars(rates)
