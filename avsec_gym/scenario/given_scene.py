"""A scene that a CommonRoad file gives: its road, its goal, its obstacles."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.geometry import wrap_angle
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.builder import obstacles_of
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.planning_scenario import PlanningScenario
from avsec_gym.scenario.scene import Motion

AS_GIVEN = "as given"
"""Stands where the name of an intention would: the file's own goal."""


@dataclass(frozen=True, eq=False)
class GivenScene:
    """A planning problem with everything that is really there.

    Args:
        scenario: Start, goal, road and real obstacles.
        group: A subset that the scene belongs to.
    """

    scenario: PlanningScenario
    group: str = "CommonRoad"

    @property
    def id(self) -> str:
        """The id of the scenario."""
        return self.scenario.id

    def truth(self) -> Obstacles:
        """The real obstacles."""
        return self.scenario.obstacles

    def problem(
        self,
        intention: Intention | None = None,
        believed: Boxes3D | None = None,
        motion: Motion = Motion.TRUTH,
        road_type: RoadType | None = None,
    ) -> PlanningScenario:
        """What the planner is asked when perception believes in certain boxes.

        Args:
            intention: Driving intention; not used: the goal is given.
            believed: Detected boxes, seen from the start pose; they stand.  None: the truth.
            motion: Knowledge of the true obstacles' motion that the planner has.
            road_type: Road type; not used: the start is given.
        """
        if believed is not None:
            return self.scenario.with_obstacles(self._placed(obstacles_of(believed)))
        if motion == Motion.TRUTH:
            return self.scenario
        return self.scenario.with_obstacles(_standing(self.truth(), self.scenario.start.step))

    def _placed(self, obstacles: Obstacles) -> Obstacles:
        """Obstacles of the ego frame in the scenario's frame."""
        start = self.scenario.start
        cos, sin = np.cos(start.heading), np.sin(start.heading)
        poses = obstacles.poses.copy()
        poses[..., :2] = poses[..., :2] @ np.array([[cos, sin], [-sin, cos]]) + (start.x, start.y)
        poses[..., 2] = wrap_angle(poses[..., 2] + start.heading)
        return replace(obstacles, poses=poses)


def _standing(obstacles: Obstacles, step: int) -> Obstacles:
    """The obstacles that are there at a time step, as if they stood for ever."""
    index = obstacles.pose_index(step)
    there = index >= 0
    rows = np.nonzero(there)[0]
    return Obstacles(
        ids=obstacles.ids[there],
        categories=obstacles.categories[there],
        shapes=tuple(obstacles.shapes[i] for i in rows),
        poses=obstacles.poses[rows, index[rows]][:, None],
        speeds=np.zeros((len(rows), 1)),
        steps=np.ones(len(rows), np.int64),
        first_step=np.full(len(rows), step),
        static=np.ones(len(rows), bool),
    )
