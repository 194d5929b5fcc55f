"""Contested objects: those that a car must not miss, whatever else it sees.

The sharpest of the measures that know the planner: an object is contested with an intention if a
car that believes in everything but this object drives unsafely, and one that believes in everything
drives safely.  All others may be missed one at a time without harm, which implies nothing for
several missed together.  It asks the very planner that is then judged, and no other.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avsec_gym.pipeline import run_episode
from avsec_gym.planners.planner import Planner
from avsec_gym.scenario.builder import is_obstacle
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Motion, Scene


def contested_objects(
    scene: Scene,
    intention: Intention,
    *,
    motion: Motion = Motion.TRUTH,
    planner: Planner | None = None,
) -> NDArray[np.bool_]:
    """Which objects of a scene a car must not miss.

    Args:
        scene: The real scene.
        intention: The driving intention.
        motion: The objects that the planner takes as moving.
        planner: The motion planner; None: A* over motion primitives.

    Returns:
        Shape (N,), of the scene's boxes; none where a car that sees all drives unsafely.

    Example:
        >>> from avsec_gym.scenario.scene_sets import procedural_scenes
        >>> (scene,) = (s for s in procedural_scenes(16).labelled if s.id == "street-000013")
        >>> int(contested_objects(scene, Intention.RIGHT).sum())
        1
    """

    def safe(kept: NDArray[np.bool_]) -> bool:
        episode = run_episode(scene, intention, scene.boxes[kept], motion=motion, planner=planner)
        return episode.record.safe

    count = len(scene.boxes)
    everything, result = np.ones(count, bool), np.zeros(count, bool)
    if safe(everything):
        for i in np.flatnonzero(is_obstacle(scene.boxes)):
            result[i] = not safe(np.arange(count) != i)
    return result
