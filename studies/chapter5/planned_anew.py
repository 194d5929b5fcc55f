"""The episodes of a run planned anew on changed detections.

No network is needed: the run has stored the detections.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TypeVar

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter5.outcomes import Condition, Outcomes
from avsec_gym.metrics.safety import SafetyRecord
from avsec_gym.pipeline import run_episode
from avsec_gym.planners.planner import MotionPrimitivePlanner, Planner
from avsec_gym.progress import Progress, no_progress
from avsec_gym.scenario.frame_scenes import FrameScenes
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Motion, Scene

Name = TypeVar("Name")
Change = Callable[[Boxes3D, Scene, Intention], Boxes3D]
"""A function from all detections of a scene, whatever their score, to the boxes that are planned
on with an intention."""


def planned_anew(
    outcomes: Outcomes,
    scenes: FrameScenes,
    motion: Motion,
    conditions: Sequence[Condition],
    changes: Mapping[Name, Change],
    on_progress: Progress = no_progress,
    planner: Planner | None = None,
) -> dict[tuple[Condition, Name], list[SafetyRecord]]:
    """The episodes of every condition under every change, all intentions of a scenario together.

    Args:
        outcomes: The outcomes of a run.
        scenes: The run's scenes.
        motion: The objects that its planner takes as moving.
        conditions: The conditions to plan anew.
        changes: The changes by their names.
        on_progress: Function that gets the number of scenarios that are done, and of all.
        planner: The motion planner; None: A* over motion primitives, as the run's.

    Returns:
        Records of each condition and change, sorted by scenario and intention as
        `Outcomes.records` are.
    """
    by_id = {scene.id: scene for scene in scenes.scenes.labelled}
    planner = MotionPrimitivePlanner() if planner is None else planner
    records: dict[tuple[Condition, Name], list[SafetyRecord]] = {
        (condition, name): [] for condition in conditions for name in changes
    }
    for number, scenario in enumerate(outcomes.scenarios):
        scene = by_id[scenario]
        for condition in conditions:
            for look in outcomes.looks(condition):
                boxes = outcomes.detections(condition, look)[number]
                for name, change in changes.items():
                    for intention in Intention if look is None else (look,):
                        believed = change(boxes, scene, intention)
                        episode = run_episode(
                            scene, intention, believed, motion=motion, planner=planner
                        )
                        records[condition, name].append(episode.record)
        on_progress(number + 1, len(outcomes.scenarios))
    for own in records.values():
        own.sort(key=lambda record: (record.scenario, record.intention))
    return records
