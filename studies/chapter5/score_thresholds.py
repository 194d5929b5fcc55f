"""Does the answer depend on the score from which on boxes are planned on?

    python -m studies.chapter5.score_thresholds RUN

Plans anew on the detections that a run has stored, for several thresholds; no network is needed.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from avsec_gym.boxes import Boxes3D
from avsec_gym.console import progress
from avsec_gym.experiments.chapter5.attack_names import attack_name, detector_name
from avsec_gym.experiments.chapter5.outcomes import Condition, Outcomes
from avsec_gym.experiments.chapter5.scenes import OPTIONS, labels_of, scenes_of
from avsec_gym.experiments.chapter5.settings import PATCHES, PERTURBATIONS, UNATTACKED
from avsec_gym.kitti.detections import above
from avsec_gym.metrics.safety import SafetyRates
from avsec_gym.progress import Progress, no_progress
from avsec_gym.report.markdown_table import markdown_table, share
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.scenario.frame_scenes import FrameScenes
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Motion, Scene
from studies.chapter5.planned_anew import planned_anew
from studies.chapter5.run_page import run_page

THRESHOLDS = (0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7)
"""Thresholds of scores that are probabilities."""


@dataclass(frozen=True)
class ThresholdRow:
    """A condition with one threshold, the three intentions together.

    Args:
        condition: The detector under its attack.
        threshold: The least score of a box that is planned on.
        rates: The three rates.
    """

    condition: Condition
    threshold: float
    rates: SafetyRates


@dataclass(frozen=True)
class SweptThresholds:
    """The study: the number of scenarios, and a row for each condition and threshold."""

    scenarios: int
    rows: Sequence[ThresholdRow]


def threshold_rows(
    outcomes: Outcomes,
    scenes: FrameScenes,
    motion: Motion,
    thresholds: Sequence[float] = THRESHOLDS,
    on_progress: Progress = no_progress,
) -> list[ThresholdRow]:
    """Rates by threshold: unattacked, under the last step of perturbations, and under patches.

    Args:
        outcomes: The outcomes of a run.
        scenes: The run's scenes.
        motion: The objects that its planner takes as moving.
        thresholds: The least scores of boxes that are planned on.
        on_progress: Function that gets the number of scenarios that are done, and of all.

    Returns:
        A row for each condition and threshold.
    """
    wanted = (UNATTACKED, *PERTURBATIONS, *PATCHES)
    conditions = [each for each in outcomes.strongest if each.attack in wanted]
    changes = {least: partial(_surer, least) for least in thresholds}
    records = planned_anew(outcomes, scenes, motion, conditions, changes, on_progress)
    return [
        ThresholdRow(condition, least, SafetyRates.of(own))
        for (condition, least), own in records.items()
    ]


def _surer(least: float, boxes: Boxes3D, _: Scene, __: Intention) -> Boxes3D:
    return above(boxes, least)


def page(found: SweptThresholds, command: str) -> str:
    """Safe driving by condition and threshold as Markdown, collisions below.

    Args:
        found: The result.
        command: The command that made it.
    """
    thresholds = list(dict.fromkeys(row.threshold for row in found.rows))
    lines = [
        "# Driving safety by score threshold",
        "",
        f"{found.scenarios:,} scenarios, the three intentions together, planned anew on the"
        f" detections of [chapter5.md](chapter5.md)'s run by `{command}`. Boxes with a lower"
        " score are not planned on. In %.",
        "",
    ]
    columns = ["detector", "attack", *(f"{threshold:g}" for threshold in thresholds)]
    for title, shares in (
        ("Safe driving", [row.rates.safe_driving_rate for row in found.rows]),
        ("Collisions", [row.rates.collision_rate for row in found.rows]),
    ):
        cells: dict[Condition, list[str]] = {}
        for row, value in zip(found.rows, shares, strict=True):
            cells.setdefault(row.condition, []).append(share(value))
        rows = [
            [detector_name(each.detector), attack_name(each.attack, each.strength), *own]
            for each, own in cells.items()
        ]
        lines += [f"## {title}", "", *markdown_table(columns, rows), ""]
    return "\n".join(lines)


def main(arguments: Sequence[str] | None = None) -> int:
    """Print rows as JSON; returns the exit code."""
    return run_page(__spec__.name, __doc__, arguments, _swept, page)


def _swept(run: RunFolder) -> SweptThresholds:
    outcomes = Outcomes(run, labels_of(run.configuration))
    motion = Motion.named({**OPTIONS, **run.configuration.options}["motion"])
    with progress("driving") as shown:
        rows = threshold_rows(outcomes, scenes_of(run.configuration), motion, on_progress=shown)
    return SweptThresholds(len(outcomes.scenarios), rows)


if __name__ == "__main__":
    sys.exit(main())
