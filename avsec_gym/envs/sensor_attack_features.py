"""What an attacker on sensors knows of a scene and of its last query, as one flat vector."""

from __future__ import annotations

import numpy as np

from avsec_gym.attacks.attack import LEFT
from avsec_gym.boxes import Boxes3D
from avsec_gym.envs.sensor_attack_game import QueryOutcome, Situation
from avsec_gym.geometry import Floats, bird_eye_iou, ego_to_camera, project
from avsec_gym.metrics.safety import COLLISION, SAFE, UNPLANNED
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.builder import is_obstacle
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Scene

NEAREST = 8
"""Real objects in the vector."""
GHOSTS = 3
"""Boxes where no object is."""
SAME = 0.1
"""Bird's-eye overlap from which on a box is taken for an object's."""
SIZE = 9 + 12 * NEAREST + 3 * GHOSTS + 5
"""The size without the last action."""

_OUTCOMES = (SAFE, COLLISION, UNPLANNED)
_SCALE = np.array([1.0, 50.0, 20.0, 1.0, 1.0, 10.0, 4.0, 1.0])
_GROUND = 1.65
"""Metres below the camera."""


def features(situation: Situation, last: QueryOutcome | None, left: float) -> Floats:
    """Start, goal, objects, ghosts, the last query.

    Args:
        situation: The scene and the intention that are attacked.
        last: The last query; None before the first, when scores are the unattacked ones.
        left: The share of the queries that is left.

    Returns:
        Shape (SIZE,), in [-1, 1]: start speed / 15 m/s; 1 on a highway; the intention (left,
        straight, right; one-hot); column and row of the goal's middle on the ground, -1 to 1
        across the left image; number of obstacles / 32; planned time without an attack / 3 s.
        The 8 nearest obstacles ahead, each as present, x / 50 m, y / 20 m, cos and sin of the
        heading, length / 10 m, width / 4 m, moving, column, row, best score of a box on it
        without an attack and now.  The 3 surest boxes now where no obstacle is, each as score,
        x / 50 m, y / 20 m.  Outcome of the last query (safe, collision, unplanned; one-hot, zero
        before the first), its planned time / 3 s (0 if unplanned), share of queries left.
    """
    scene, unattacked = situation.scene, situation.unattacked
    now = unattacked if last is None else last
    problem = unattacked.episode.problem
    goal = problem.goals[0].region[0]  # type: ignore[index]
    head = [problem.start.velocity / 15.0, float(scene.road_type == RoadType.HIGHWAY)]
    head += [float(situation.intention == each) for each in Intention]
    head += [*_in_image(unattacked, np.array([[goal.x, goal.y, 0.0]]))[0]]  # type: ignore[union-attr]
    obstacles = scene.boxes[is_obstacle(scene.boxes)]
    head += [min(1.0, len(obstacles) / 32), _share_of_time(unattacked)]
    outcome = [
        float(last is not None and last.episode.record.outcome == each) for each in _OUTCOMES
    ]
    after = [*outcome, 0.0 if last is None else _share_of_time(last), max(left, 0.0)]
    found = [np.ravel(_objects(scene, unattacked, now)), np.ravel(_ghosts(obstacles, now))]
    return np.clip(np.concatenate([head, *found, after]), -1.0, 1.0)


def best_scores(obstacles: Boxes3D, boxes: Boxes3D) -> Floats:
    """The best score of a box on each obstacle, 0 where there is none, shape (N,)."""
    return np.where(_on(obstacles, boxes), boxes.score, 0.0).max(axis=1, initial=0.0)


def ghosts_among(obstacles: Boxes3D, boxes: Boxes3D) -> Boxes3D:
    """The boxes that would be obstacles, and lie on none."""
    return boxes[is_obstacle(boxes) & ~_on(obstacles, boxes).any(axis=0)]


def _on(obstacles: Boxes3D, boxes: Boxes3D) -> np.ndarray:
    """Which box lies on which obstacle, shape (N, M)."""
    if not len(obstacles) or not len(boxes):
        return np.zeros((len(obstacles), len(boxes)), bool)
    overlap = bird_eye_iou(
        obstacles.poses,
        np.column_stack([obstacles.length, obstacles.width]),
        boxes.poses,
        np.column_stack([boxes.length, boxes.width]),
    )
    return np.asarray((overlap >= SAME) & is_obstacle(boxes))


def _objects(scene: Scene, unattacked: QueryOutcome, now: QueryOutcome) -> Floats:
    obstacles = scene.boxes[is_obstacle(scene.boxes) & (scene.boxes.poses[:, 0] > 1)]
    near = obstacles[np.argsort(np.hypot(*obstacles.poses[:, :2].T), kind="stable")[:NEAREST]]
    x, y, heading = near.poses.T
    moving = np.zeros(len(near)) if near.moving is None else near.moving
    rows = np.zeros((NEAREST, 12))
    shape = [np.ones(len(near)), x, y, np.cos(heading), np.sin(heading), near.length, near.width]
    rows[: len(near), :8] = np.column_stack([*shape, moving]) / _SCALE
    rows[: len(near), 8:10] = _in_image(unattacked, near.poses)
    rows[: len(near), 10] = best_scores(near, unattacked.perception.detections)
    rows[: len(near), 11] = best_scores(near, now.perception.detections)
    return rows


def _ghosts(obstacles: Boxes3D, now: QueryOutcome) -> Floats:
    ghosts = ghosts_among(obstacles, now.perception.detections)
    surest = ghosts[np.argsort(-ghosts.score, kind="stable")[:GHOSTS]]
    rows = np.zeros((GHOSTS, 3))
    rows[: len(surest)] = np.column_stack([surest.score, surest.poses[:, :2] / _SCALE[1:3]])
    return rows


def _in_image(look: QueryOutcome, poses: Floats) -> Floats:
    """Column and row of points on the ground, -1 to 1 across the left image, shape (N, 2)."""
    location, _ = ego_to_camera(poses, _GROUND)
    pixels, _ = project(look.frame.calibration.projection(LEFT), location)
    height, width = look.frame.image(LEFT).shape[:2]
    return np.clip(2.0 * pixels / [width - 1, height - 1] - 1.0, -1.0, 1.0)


def _share_of_time(look: QueryOutcome) -> float:
    record = look.episode.record
    return min(record.cost / 3.0, 1.0) if record.planned else 0.0
