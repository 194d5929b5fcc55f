"""The drives of a run planned anew on what was seen, changed: which drives would it have given?

No network is needed: the detections that the run has stored are what is changed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TypeVar

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter5.outcomes import Condition, Outcomes
from avsec_gym.metrics.safety import SafetyRecord
from avsec_gym.pipeline import run_episode
from avsec_gym.planners.planner import MotionPrimitivePlanner
from avsec_gym.scenario.frame_scenes import FrameScenes
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Motion, Scene

Name = TypeVar("Name")
Change = Callable[[Boxes3D, Scene], Boxes3D]
"""From all detections of a scene, whatever their score, to the boxes that are planned on."""


def planned_anew(
    outcomes: Outcomes,
    scenes: FrameScenes,
    motion: Motion,
    conditions: Sequence[Condition],
    changes: Mapping[Name, Change],
    on_progress: Callable[[int, int], None] = lambda done, total: None,
) -> dict[tuple[Condition, Name], list[SafetyRecord]]:
    """The drives of every condition under every change, all intentions of a scenario together.

    Args:
        outcomes: Of a run.
        scenes: Its scenes.
        motion: What its planner was told of motion.
        conditions: Those to plan anew.
        changes: By what they are called.
        on_progress: Told how many scenarios of how many are driven.
    """
    by_id = {scene.id: scene for scene in scenes.scenes.labelled}
    planner = MotionPrimitivePlanner()
    records: dict[tuple[Condition, Name], list[SafetyRecord]] = {
        (one, name): [] for one in conditions for name in changes
    }
    for number, scenario in enumerate(outcomes.scenarios):
        scene = by_id[scenario]
        for one in conditions:
            for look in outcomes.looks(one):
                boxes = outcomes.detections(one, look)[number]
                for name, change in changes.items():
                    believed = change(boxes, scene)
                    for intention in Intention if look is None else (look,):
                        driven = run_episode(
                            scene, intention, believed, motion=motion, planner=planner
                        )
                        records[one, name].append(driven.record)
        on_progress(number + 1, len(outcomes.scenarios))
    return records
