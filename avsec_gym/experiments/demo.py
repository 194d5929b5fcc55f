"""The demo: chapter 5 in small, both detectors in a dozen procedural scenes, in minutes."""

from __future__ import annotations

from collections.abc import Mapping
from statistics import fmean
from typing import Any

from avsec_gym.experiments.chapter5.attacked_drives import attacked_cells, attacked_inputs
from avsec_gym.experiments.chapter5.experiments import SECTION
from avsec_gym.experiments.chapter5.outcomes import CATEGORY, Outcomes
from avsec_gym.experiments.chapter5.scenes import OPTIONS
from avsec_gym.experiments.chapter5.settings import DETECTORS, PATCHES, PERTURBATIONS, UNATTACKED
from avsec_gym.experiments.chapter5.tables import Row, named
from avsec_gym.experiments.chapter5.trained import patches_there
from avsec_gym.experiments.chapter5.true_drives import true_cells
from avsec_gym.experiments.procedural_frames import PROCEDURAL, USUAL_COUNT
from avsec_gym.metrics.average_precision import LOW_IOU, STANDARD_IOU
from avsec_gym.metrics.average_precision_frames import LEVELS
from avsec_gym.metrics.safety import SafetyRates
from avsec_gym.planners.planner import Algorithm
from avsec_gym.runs.experiment import Cell, Configuration, Experiment
from avsec_gym.scenario.intention import Intention

_PATCH = PATCHES[0]
_TRUTH: Row = {
    "detector": None,
    "attack": UNATTACKED,
    "strength": 0.0,
    "whole_levels": False,
    "precision": None,
    "precision_iou_0.5": None,
    "precision_ceiling": None,
    "labels": None,
}


def unpatched(options: Mapping[str, Any]) -> tuple[str, ...]:
    """Detectors that there is no trained patch against: the demo leaves their patch out.

    Args:
        options: See `avsec_gym.experiments.chapter5.scenes.OPTIONS`.
    """
    there = {**OPTIONS, **options}
    return tuple(name for name in DETECTORS if "patch" not in patches_there(name, there))


def demo_rows(outcomes: Outcomes) -> list[Row]:
    """What every detector comes to under every attack, the three intentions together.

    Perturbations at their last step only; first of all what the planner makes of the truth.

    Args:
        outcomes: Of a run.

    Returns:
        Rows with ``detector`` (None: the truth), ``attack``, ``strength``, the average precision
        of moderate cars in 3D at IoU 0.7 and 0.5 (``precision``, ``precision_iou_0.5``; percent,
        11 recall points), how many labels count (``labels``) and what perfect detections of them
        reach (``precision_ceiling``), and the rates as of `SafetyRates.to_json`.
    """
    true = [one for way in Intention for one in outcomes.true_records(Algorithm.ASTAR, way)]
    rows: list[Row] = [{**_TRUTH, **SafetyRates.of(true).to_json()}]
    for condition in outcomes.strongest:
        strict, low = (
            fmean(
                outcomes.precision(condition, way, min_iou, 0).value(CATEGORY)
                for way in outcomes.looks(condition)
            )
            for min_iou in (STANDARD_IOU, LOW_IOU)
        )
        found = outcomes.precision(condition, outcomes.looks(condition)[0], STANDARD_IOU, 0)
        moderate = LEVELS.index("moderate")
        rows.append(
            {
                **named(condition),
                "precision": strict,
                "precision_iou_0.5": low,
                "precision_ceiling": float(found.ceiling[0, moderate, 0]),
                "labels": int(found.labels[0, moderate]),
                **outcomes.rates(condition).to_json(),
            }
        )
    return rows


def _demo_cells(configuration: Configuration) -> list[Cell]:
    without = unpatched(configuration.options)
    cells = true_cells(configuration)
    for detector in DETECTORS:
        patches = () if detector in without else (_PATCH,)
        attacks = (UNATTACKED, PERTURBATIONS[-1], *patches)
        cells += attacked_cells(configuration, attacks, (detector,))
    return cells


DEMO = Experiment(
    "demo",
    "What do attacks take of precision and of driving safety, in a dozen scenes?",
    "Chapter 5",
    _demo_cells,
    attacked_inputs,
    {**OPTIONS, "sanity_sheet": False},
    Configuration(PROCEDURAL, USUAL_COUNT),
    section=SECTION,
)
