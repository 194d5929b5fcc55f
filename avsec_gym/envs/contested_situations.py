"""Situations of attacks on sensors in which an obstacle is in the car's way, and which it is."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np
from shapely.geometry import LineString, Point

from avsec_gym.boxes import Boxes3D
from avsec_gym.envs.sensor_attack_game import SensorAttackGame, Situation
from avsec_gym.evaluation.contested import is_contested
from avsec_gym.pipeline import Perception
from avsec_gym.scenario.builder import is_obstacle
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Scene
from avsec_gym.scenario.shapes import Disc, Rectangle

_AHEAD = 1.0
"""Metres ahead of the car from which on an obstacle may be the one."""


def contested_situations(game: SensorAttackGame) -> Iterator[tuple[Scene, Intention]]:
    """Contested scenes and intentions, safe and without an alarm while there is no attack.

    Args:
        game: The scenes and the car; each scene is looked at when its turn comes.
    """
    for scene, intention in product(game.scenes.scenes.labelled, Intention):
        if is_contested(scene, intention):
            unattacked = game.situation(scene, intention).unattacked
            if unattacked.episode.record.safe and not unattacked.report.alarm:
                yield scene, intention


def obstacle_in_the_way(game: SensorAttackGame, situation: Situation) -> Boxes3D:
    """The obstacle without which the car would drive into it.

    Of several, or where it takes more than one, that nearest to the straight line from the car to
    the middle of its goal.

    Args:
        game: The car.
        situation: The scene and the intention; an obstacle is ahead.

    Returns:
        One box, camera frame.
    """
    boxes, scene = situation.scene.boxes, situation.scene
    ahead = np.flatnonzero(is_obstacle(boxes) & (boxes.poses[:, 0] > _AHEAD))
    region = situation.unattacked.episode.problem.goals[0].region
    assert region, "a lane is a region"
    goal = region[0]
    assert isinstance(goal, Rectangle | Disc), "that of a lane has a middle"
    line = LineString([(0.0, 0.0), (goal.x, goal.y)])
    nearest = sorted(ahead, key=lambda index: line.distance(Point(boxes.poses[index, :2])))
    for index in nearest:
        others = boxes[np.arange(len(boxes)) != index]
        believed = Perception(others, others, None)
        if not game.pipeline.run_episode(scene, believed, situation.intention).record.safe:
            return boxes[[index]]
    return boxes[nearest[:1]]
