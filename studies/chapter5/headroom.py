"""How much safety perception can lose or gain: cars that see nothing, all, or all and a ghost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from avsec_gym.attacks.attack import LEFT
from avsec_gym.attacks.patch_ghosts import ghost_box
from avsec_gym.attacks.patch_placement import random_place
from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter5.settings import PLACEMENTS
from avsec_gym.frame import SensorFrame
from avsec_gym.metrics.estimate import Estimate
from avsec_gym.metrics.safety import SafetyRates, SafetyRecord
from avsec_gym.pipeline import run_episode
from avsec_gym.planners.planner import MotionPrimitivePlanner
from avsec_gym.progress import Progress, no_progress
from avsec_gym.scenario.frame_scenes import FrameScenes
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Motion, Scene
from studies.chapter5.corrected_episodes import gain
from studies.chapter5.known_motion import with_known_motion

TRUTH, NOTHING = "truth", "nothing"
RANDOM, SPECIFIC = PLACEMENTS


@dataclass(frozen=True)
class HeadroomRow:
    """A car without a detector, the three intentions together.

    Args:
        seen: What its planner is given.
        rates: The three rates.
        gain: Safe driving gained against the truth, percentage points.
        by_intention: Safe driving rate of each intention.
    """

    seen: str
    rates: SafetyRates
    gain: Estimate
    by_intention: Mapping[str, float]


def headroom_rows(
    scenes: FrameScenes,
    scenarios: Sequence[str],
    motion: Motion,
    seed: int,
    on_progress: Progress = no_progress,
) -> list[HeadroomRow]:
    """Rates of cars without a detector: what missing everything costs, and seeing a ghost.

    Args:
        scenes: The scenes of a run.
        scenarios: The ids of those that count.
        motion: The objects that the planner takes as moving.
        seed: The seed of the run: patches stand where they stood there.
        on_progress: Function that gets the number of scenarios that are done, and of all.

    Returns:
        A row for the truth, for nothing at all, and for the truth with b* of a patch of the usual
        size beside it, at random and specific places.
    """
    by_id = {scene.id: scene for scene in scenes.scenes.labelled}
    planner = MotionPrimitivePlanner()
    records: dict[str, list[SafetyRecord]] = {}
    for number, scenario in enumerate(scenarios):
        scene = by_id[scenario]
        frame = scenes.frame(scene)
        for intention in Intention:
            truth, nothing = (with_known_motion(each) for each in (scene.boxes, Boxes3D.empty()))
            believed = {TRUTH: truth, NOTHING: nothing}
            for placement in PLACEMENTS:
                ghost = _ghost(frame, scene, seed, intention if placement == SPECIFIC else None)
                believed[placement] = Boxes3D.concatenate([truth, with_known_motion(ghost)])
            for name, boxes in believed.items():
                episode = run_episode(scene, intention, boxes, motion=motion, planner=planner)
                records.setdefault(name, []).append(episode.record)
        on_progress(number + 1, len(scenarios))
    return [
        HeadroomRow(
            name,
            SafetyRates.of(own),
            gain(records[TRUTH], own),
            {str(intention): _safe(own, intention) for intention in Intention},
        )
        for name, own in records.items()
    ]


def _safe(records: Sequence[SafetyRecord], intention: Intention) -> float:
    own = [record.safe for record in records if record.intention == intention]
    return sum(own) / len(own)


def _ghost(frame: SensorFrame, scene: Scene, seed: int, intention: Intention | None) -> Boxes3D:
    """b* where the run has its patch; an intention if it is specific."""
    own = [seed, scene.number]
    if intention is not None:
        own.append(list(Intention).index(intention))
    size = frame.image(LEFT).shape[:2]
    place = random_place(frame.calibration, size, own, objects=scene.boxes, intention=intention)
    return ghost_box(place, frame.calibration)
