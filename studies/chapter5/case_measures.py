"""Measures of perception in single cases: a scene, with an intention, as it is seen.

Some count cars whatever is driven, others know where the car wants to go; each is larger where
perception is better.  A case has a numerator and a denominator, so that cases can be summed: a
recall over many scenes is that of all their cars.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter5.outcomes import CATEGORY, Condition, Outcomes
from avsec_gym.geometry import Floats
from avsec_gym.kitti.detections import above
from avsec_gym.metrics.contact_recall import contact_weights
from avsec_gym.metrics.ghosts import SAME, ghosts, iou_from_above, meant
from avsec_gym.pipeline import run_episode
from avsec_gym.planners.planner import MotionPrimitivePlanner
from avsec_gym.progress import Progress, no_progress
from avsec_gym.scenario.builder import is_obstacle
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Motion, Scene
from studies.chapter5.known_motion import with_known_motion
from studies.chapter5.measures.contested_objects import contested_objects
from studies.chapter5.measures.planning_kl import chances, occupied_cells, summed_divergence
from studies.chapter5.measures.support_distance import MISSED, support_distance_error
from studies.chapter5.measures.trajectory_bundle import TrajectoryBundle, trajectory_bundle

IN_REACH = 20.0
"""Metres from the camera: goals are 15 m ahead."""
CARS_FOUND, REACH_FOUND = "cars found", "cars in reach found"
CONTACT_RECALL, CONTACT_AGREEMENT = "found by time to contact", "the same, less ghosts"
CONTESTED, SUPPORT, PLANNING_KL = "contested objects found", "support distance", "planning KL"
CASE_MEASURES = (
    CARS_FOUND, REACH_FOUND, CONTACT_RECALL, CONTACT_AGREEMENT, SUPPORT, CONTESTED, PLANNING_KL,
)  # fmt: skip
"""The first two count cars, whatever is driven; of the support distance the error counts, and of
planning the divergence, both negative."""

CaseMeasures = Mapping[Condition, Mapping[str, Floats]]
"""Numerators and denominators by scenario and intention, shape (S, 3, 2); a denominator of 0: there
is nothing to measure."""


@dataclass(frozen=True, eq=False)
class _Asked:
    """What a scene asks of perception with an intention, whatever is seen."""

    contact: Floats
    contested: NDArray[np.bool_]
    bundle: TrajectoryBundle
    chances: Floats
    cells: NDArray[np.int64]
    way: Floats
    """Poses of the car on the plan that the truth gives; where it stands, if that gives none."""


def case_measures(
    outcomes: Outcomes,
    scenes: Sequence[Scene],
    motion: Motion,
    conditions: Sequence[Condition],
    threshold: float,
    on_progress: Progress = no_progress,
) -> CaseMeasures:
    """Measure every case of some conditions.

    Args:
        outcomes: The outcomes of a run.
        scenes: The scenes of the run, in any order, further ones among them.
        motion: The objects that the run's planner takes as moving.
        conditions: The conditions that count.
        threshold: The least score of a box that is planned on; others do not count.
        on_progress: Function that gets the number of scenarios that are done, and of all.
    """
    by_id, count = {scene.id: scene for scene in scenes}, len(outcomes.scenarios)
    result = {
        condition: {name: np.zeros((count, len(Intention), 2)) for name in CASE_MEASURES}
        for condition in conditions
    }
    for number, scenario in enumerate(outcomes.scenarios):
        scene, labels = by_id[scenario], outcomes.labels[scenario]
        # A planner that takes motion from a classifier needs to know it of the truth, too.
        scene = replace(scene, boxes=with_known_motion(scene.boxes))
        asked = [_asked(scene, intention, motion) for intention in Intention]
        for condition in conditions:
            looks = outcomes.looks(condition)
            for column, intention in enumerate(Intention):
                look = looks[column] if len(looks) > 1 else looks[0]
                believed = above(outcomes.detections(condition, look)[number], threshold)
                case = _case(scene, labels, believed, intention, motion, asked[column])
                for name, shares in case.items():
                    result[condition][name][number, column] = shares
        on_progress(number + 1, count)
    return result


def _asked(scene: Scene, intention: Intention, motion: Motion) -> _Asked:
    problem = scene.problem(intention, motion=motion)
    real = is_obstacle(scene.boxes)
    bundle = trajectory_bundle(problem)
    episode = run_episode(scene, intention, motion=motion, planner=MotionPrimitivePlanner())
    way = np.zeros((1, 3))
    if episode.plan.trajectory is not None:
        way = episode.plan.trajectory[:, [0, 1, 3]]
    return _Asked(
        contact_weights(problem),
        contested_objects(scene, intention, motion=motion)[real],
        bundle,
        chances(bundle, problem),
        occupied_cells(bundle),
        way,
    )


def _case(
    scene: Scene,
    labels: Boxes3D,
    believed: Boxes3D,
    intention: Intention,
    motion: Motion,
    asked: _Asked,
) -> dict[str, tuple[float, float]]:
    """Numerator and denominator of each measure."""
    believed = believed[is_obstacle(believed)]
    cars = labels[labels.category == CATEGORY]
    car_found = meant(cars, believed)
    near = np.hypot(cars.location[:, 0], cars.location[:, 2]) < IN_REACH
    real = scene.boxes[is_obstacle(scene.boxes)]
    found = meant(real, believed)
    problem = scene.problem(intention, believed, motion)
    invented = ghosts(believed, labels, overlap=SAME)
    # What stands in a region that is not labelled is neither real nor invented.
    in_view = invented | (iou_from_above(believed, real) >= SAME).any(axis=1)
    found_weight = float(asked.contact[found].sum())
    real_weight = float(asked.contact.sum())
    ghost_weight = float(contact_weights(problem)[invented].sum())
    error = support_distance_error(_rectangles(real), _rectangles(believed[in_view]), asked.way)
    divergence = summed_divergence(asked.chances, chances(asked.bundle, problem), asked.cells)
    return {
        CARS_FOUND: (float(car_found.sum()), float(len(cars))),
        REACH_FOUND: (float((car_found & near).sum()), float(near.sum())),
        CONTACT_RECALL: (found_weight, real_weight),
        CONTACT_AGREEMENT: (found_weight, real_weight + ghost_weight),
        # From 0, wrong as can be, to 1.
        SUPPORT: (0.0, 0.0) if np.isnan(error) else (1 - error / MISSED, 1.0),
        CONTESTED: (float((found & asked.contested).sum()), float(asked.contested.sum())),
        PLANNING_KL: (-divergence, 1.0),
    }


def _rectangles(boxes: Boxes3D) -> Floats:
    """x, y, length, width, heading in the ego frame, shape (N, 5)."""
    return np.column_stack([boxes.poses[:, :2], boxes.length, boxes.width, boxes.poses[:, 2]])
