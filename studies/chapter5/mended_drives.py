"""Which errors of a detector does safe driving pay for?  Drives with one kind of them put right.

As `studies.perception.mended_detections` asks of precision, this asks of safety: each
kind is put right by the labels, all else stays as it was found.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter5.ghost_positions import ghosts, iou_from_above
from avsec_gym.experiments.chapter5.outcomes import Outcomes
from avsec_gym.experiments.chapter5.settings import (
    PATCHES,
    PERTURBATIONS,
    TEXTURE,
    TEXTURE_ATTACKED,
    UNATTACKED,
)
from avsec_gym.experiments.chapter5.tables import Row, named
from avsec_gym.kitti.detections import above
from avsec_gym.metrics.paired import paired_differences
from avsec_gym.metrics.safety import SafetyRates, SafetyRecord
from avsec_gym.scenario.builder import is_obstacle
from avsec_gym.scenario.frame_scenes import FrameScenes
from avsec_gym.scenario.scene import Motion, Scene
from studies.chapter5.planned_anew import Change, planned_anew

SAME = 0.1
"""Intersection over union from above with which a box means a real object; as in `ghosts`."""
AS_FOUND, EVERYTHING = "as found", "everything"
MENDED = (AS_FOUND, "ghosts", "misses", "places", EVERYTHING)
"""``ghosts``: boxes that stand for nothing real are dropped; ``misses``: real objects that no box
means are added; ``places``: boxes that mean a real object are put where it is."""


def mended_rows(
    outcomes: Outcomes,
    scenes: FrameScenes,
    motion: Motion,
    threshold: float,
    on_progress: Callable[[int, int], None] = lambda done, total: None,
) -> list[Row]:
    """Rates with each kind of error mended, and the safe driving that mending it gains.

    Args:
        outcomes: Of a run.
        scenes: Its scenes.
        motion: What its planner was told of motion.
        threshold: Less sure boxes are not planned on.
        on_progress: Told how many scenarios of how many are driven.

    Returns:
        A row for each condition and each of `MENDED`, the three intentions together; ``gain`` and
        ``gain_interval`` (95 %, bootstrap over scenarios) against what was found.
    """
    wanted = (UNATTACKED, *PERTURBATIONS, *PATCHES, TEXTURE, TEXTURE_ATTACKED)
    conditions = [one for one in outcomes.strongest if one.attack in wanted]
    changes: dict[str, Change] = {
        name: partial(_mended, name, outcomes.labels, threshold) for name in MENDED
    }
    records = planned_anew(outcomes, scenes, motion, conditions, changes, on_progress)
    return [
        {
            **named(one),
            "mended": name,
            **SafetyRates.of(driven).to_json(),
            **gain(records[one, AS_FOUND], driven),
        }
        for (one, name), driven in records.items()
    ]


def gain(before: Sequence[SafetyRecord], after: Sequence[SafetyRecord]) -> Row:
    """Safe driving gained from one input to another on the same drives, percentage points."""
    found = paired_differences(before, after)
    bounds = found["safe_driving_rate_interval"]
    return {
        "gain": 100 * found["safe_driving_rate"],
        "gain_interval": None if bounds is None else [100 * bound for bound in bounds],
    }


def _mended(
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
