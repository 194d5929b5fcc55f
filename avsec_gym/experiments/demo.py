"""The demo: chapter 5 in small, both detectors in a dozen procedural scenes, in minutes."""

from __future__ import annotations

from dataclasses import dataclass, field
from statistics import fmean

from avsec_gym.experiments.chapter5.attacked_drives import attacked_cells, attacked_inputs
from avsec_gym.experiments.chapter5.experiments import SECTION
from avsec_gym.experiments.chapter5.outcomes import CATEGORY, Outcomes
from avsec_gym.experiments.chapter5.scenes import OPTIONS
from avsec_gym.experiments.chapter5.settings import (
    DETECTORS,
    PATCHES,
    PERTURBATIONS,
    UNATTACKED,
    Options,
)
from avsec_gym.experiments.chapter5.trained import patches_there
from avsec_gym.experiments.chapter5.true_drives import true_cells
from avsec_gym.experiments.json_rows import keyed
from avsec_gym.experiments.procedural_frames import PROCEDURAL, USUAL_COUNT
from avsec_gym.metrics.average_precision import LOW_IOU, STANDARD_IOU
from avsec_gym.metrics.average_precision_frames import LEVELS
from avsec_gym.metrics.safety import SafetyRates
from avsec_gym.planners.planner import Algorithm
from avsec_gym.runs.experiment import Cell, Configuration, Experiment
from avsec_gym.scenario.intention import Intention

_PATCH = PATCHES[0]


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


def unpatched(options: Options) -> tuple[str, ...]:
    """Detectors that there is no trained patch against: the demo leaves their patch out."""
    there = {**OPTIONS, **options}
    return tuple(name for name in DETECTORS if "patch" not in patches_there(name, there))


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
