"""Which errors of a detector cost safe driving?  Episodes with one kind of them corrected.

An oracle corrects each kind of error by the labels, and all else stays as it was found;
`studies.perception` does the same for precision.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter5.ghost_positions import ghosts, iou_from_above
from avsec_gym.experiments.chapter5.outcomes import Condition, Outcomes
from avsec_gym.experiments.chapter5.settings import (
    PATCHES,
    PERTURBATIONS,
    TEXTURE,
    TEXTURE_ATTACKED,
    UNATTACKED,
)
from avsec_gym.kitti.detections import above
from avsec_gym.metrics.estimate import NOTHING, Estimate
from avsec_gym.metrics.paired import paired_differences
from avsec_gym.metrics.safety import SafetyRates, SafetyRecord
from avsec_gym.scenario.builder import is_obstacle
from avsec_gym.scenario.frame_scenes import FrameScenes
from avsec_gym.scenario.scene import Motion, Scene
from studies.chapter5.planned_anew import Change, planned_anew

SAME = 0.1
"""Intersection over union from above with which a box means a real object; as in `ghosts`."""
AS_FOUND, EVERYTHING = "as found", "everything"
CORRECTED = (AS_FOUND, "ghosts", "misses", "places", EVERYTHING)
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
    """

    condition: Condition
    corrected: str
    rates: SafetyRates
    gain: Estimate


def corrected_rows(
    outcomes: Outcomes,
    scenes: FrameScenes,
    motion: Motion,
    threshold: float,
    on_progress: Callable[[int, int], None] = lambda done, total: None,
) -> list[CorrectedRow]:
    """Rates with each kind of error corrected, and the safe driving that this gains.

    Args:
        outcomes: The outcomes of a run.
        scenes: The run's scenes.
        motion: The objects that its planner takes as moving.
        threshold: The least score of a box that is planned on.
        on_progress: Called with the number of scenarios that are done, and of all.

    Returns:
        A row for each condition and each of `CORRECTED`.
    """
    wanted = (UNATTACKED, *PERTURBATIONS, *PATCHES, TEXTURE, TEXTURE_ATTACKED)
    conditions = [condition for condition in outcomes.strongest if condition.attack in wanted]
    changes: dict[str, Change] = {
        name: partial(_corrected, name, outcomes.labels, threshold) for name in CORRECTED
    }
    records = planned_anew(outcomes, scenes, motion, conditions, changes, on_progress)
    return [
        CorrectedRow(
            condition,
            name,
            SafetyRates.of(corrected),
            gain(records[condition, AS_FOUND], corrected),
        )
        for (condition, name), corrected in records.items()
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
) -> Boxes3D:
    found = above(boxes, threshold)
    unreal = ghosts(found, labels[scene.id], overlap=SAME)
    real = scene.boxes[is_obstacle(scene.boxes)]
    meant = iou_from_above(found, real) >= SAME
    seen, missed = real[meant.any(axis=0)], real[~meant.any(axis=0)]
    if kind == AS_FOUND:
        return found
    if kind == "ghosts":
        return found[~unreal]
    if kind == "misses":
        return Boxes3D.concatenate([found, missed])
    if kind == "places":
        return Boxes3D.concatenate([found[~meant.any(axis=1)], seen])
    return real
