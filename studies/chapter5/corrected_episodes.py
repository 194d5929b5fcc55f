"""Which errors of a detector cost safe driving?  Episodes with one kind of them corrected.

An oracle corrects each kind of error by the labels, and all else stays as it was found;
`studies.perception` does the same for precision.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter5.outcomes import Condition, Outcomes
from avsec_gym.experiments.chapter5.settings import (
    JOINT_PATCHES,
    PATCHES,
    PERTURBATIONS,
    TEXTURE,
    TEXTURE_ATTACKED,
    UNATTACKED,
)
from avsec_gym.experiments.json_rows import OPTIONAL
from avsec_gym.kitti.detections import above
from avsec_gym.metrics.estimate import NOTHING, Estimate
from avsec_gym.metrics.ghosts import SAME, ghosts, iou_from_above
from avsec_gym.metrics.many_comparisons import holm_adjusted
from avsec_gym.metrics.paired import paired_differences, scenario_p
from avsec_gym.metrics.safety import SafetyRates, SafetyRecord
from avsec_gym.progress import Progress, no_progress
from avsec_gym.scenario.builder import is_obstacle
from avsec_gym.scenario.frame_scenes import FrameScenes
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Motion, Scene
from studies.chapter5.ghost_lanes import GhostLane, ghost_lanes
from studies.chapter5.known_motion import with_known_motion
from studies.chapter5.planned_anew import Change, planned_anew

AS_FOUND, EVERYTHING = "as found", "everything"
GHOSTS_IN = {lane: f"ghosts, {lane}" for lane in GhostLane}
"""Ghosts of one lane alone; see `GhostLane`."""
CORRECTED = (AS_FOUND, "ghosts", *GHOSTS_IN.values(), "misses", "places", EVERYTHING)
"""``ghosts``: boxes that stand for nothing real are dropped; ``misses``: real objects that no box
means are added; ``places``: boxes that mean a real object are moved to where it is."""


@dataclass(frozen=True)
class CorrectedRow:
    """A condition with one kind of error corrected, the three intentions together.

    Args:
        condition: The detector under its attack.
        corrected: One of `CORRECTED`.
        rates: The three rates.
        gain: Safe driving gained against what was found, percentage points, with its 95 % interval
            by bootstrap over scenarios.
        p_holm: The p-value of the gain's being zero, after Holm's correction for all rows: of an
            exact test of scenarios that gain against scenarios that lose.  None of what was found,
            and in earlier results.
    """

    condition: Condition
    corrected: str
    rates: SafetyRates
    gain: Estimate
    p_holm: float | None = field(default=None, metadata=OPTIONAL)


def corrected_rows(
    outcomes: Outcomes,
    scenes: FrameScenes,
    motion: Motion,
    threshold: float,
    on_progress: Progress = no_progress,
) -> list[CorrectedRow]:
    """Rates with each kind of error corrected, and the safe driving that this gains.

    Args:
        outcomes: The outcomes of a run.
        scenes: The run's scenes.
        motion: The objects that its planner takes as moving.
        threshold: The least score of a box that is planned on.
        on_progress: Function that gets the number of scenarios that are done, and of all.

    Returns:
        A row for each condition and each of `CORRECTED`.
    """
    wanted = (UNATTACKED, *PERTURBATIONS, *PATCHES, *JOINT_PATCHES, TEXTURE, TEXTURE_ATTACKED)
    conditions = [condition for condition in outcomes.strongest if condition.attack in wanted]
    changes: dict[str, Change] = {
        name: partial(_corrected, name, outcomes.labels, threshold) for name in CORRECTED
    }
    records = planned_anew(outcomes, scenes, motion, conditions, changes, on_progress)
    rows = [
        CorrectedRow(
            condition,
            name,
            SafetyRates.of(corrected),
            gain(records[condition, AS_FOUND], corrected),
        )
        for (condition, name), corrected in records.items()
    ]
    p = holm_adjusted(
        [
            np.nan if name == AS_FOUND else scenario_p(records[condition, AS_FOUND], corrected)
            for (condition, name), corrected in records.items()
        ]
    )
    return [
        replace(row, p_holm=None if np.isnan(value) else float(value))
        for row, value in zip(rows, p, strict=True)
    ]


def gain(before: Sequence[SafetyRecord], after: Sequence[SafetyRecord]) -> Estimate:
    """Safe driving gained from one input to another in the same episodes, percentage points."""
    paired = paired_differences(before, after)
    if paired is None or paired.safe_driving_rate.value is None:
        return NOTHING
    value, interval = paired.safe_driving_rate.value, paired.safe_driving_rate.interval
    return Estimate(100 * value, interval and [100 * bound for bound in interval])


def _corrected(
    kind: str,
    labels: Mapping[str, Boxes3D],
    threshold: float,
    boxes: Boxes3D,
    scene: Scene,
    intention: Intention,
) -> Boxes3D:
    found = above(boxes, threshold)
    real = scene.boxes[is_obstacle(scene.boxes)]
    if found.moving is not None:
        real = with_known_motion(real)
    overlap = iou_from_above(found, real)
    meant = overlap >= SAME
    unreal = ghosts(found, labels[scene.id], overlap=SAME)
    if kind == AS_FOUND:
        return found
    if kind == "ghosts":
        return found[~unreal]
    if kind in GHOSTS_IN.values():
        lanes = np.array([GHOSTS_IN[lane] for lane in ghost_lanes(found, intention)], np.str_)
        return found[~(unreal & (lanes == kind))]
    if kind == "misses":
        return Boxes3D.concatenate([found, real[~meant.any(axis=0)]])
    if kind == "places":
        is_seen = meant.any(axis=0)
        seen = real[is_seen]
        if found.moving is not None and len(seen):
            # Where a classifier decides what moves, that stays as it was found, too.
            seen = replace(seen, moving=found.moving[overlap[:, is_seen].argmax(axis=0)])
        return Boxes3D.concatenate([found[~meant.any(axis=1)], seen])
    return real
