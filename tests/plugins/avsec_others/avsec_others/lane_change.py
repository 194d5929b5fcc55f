"""A planner without a search: one smooth change of lane for each time at which it may end."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.planners.collision import collides, collision_world_of
from avsec_gym.planners.goal import goal_arrays, reaches
from avsec_gym.planners.plan import Plan, Reason, Status
from avsec_gym.planners.vehicle import BMW_320I
from avsec_gym.scenario.planning_scenario import EgoState, PlanningScenario


@dataclass(frozen=True)
class LaneChange:
    """Constant acceleration ahead, a quintic polynomial sideways, to the goal region's middle.

    Args:
        hardest: The strongest acceleration or braking, m/s^2.
    """

    hardest: float = 3.0

    def plan(self, scenario: PlanningScenario) -> Plan:
        """The first free way among those that end at each time step of the first goal."""
        start, goal, world = scenario.start, scenario.goals[0], collision_world_of(scenario)
        goals, size = goal_arrays(scenario.goals), (BMW_320I.length / 2, BMW_320I.width / 2)
        middle = np.array(goal.region[0].polygon().centroid.coords[0] if goal.region else (0, 0))
        tried = 0
        for last in range(max(goal.steps[0], start.step + 1), goal.steps[1] + 1):
            t = np.arange(last - start.step + 1) * scenario.dt
            way = self._way(start, middle, t)
            x, y, speed, heading, _ = way[-1]
            tried += 1
            if reaches(x, y, heading, speed, last, goals) and not any(
                collides(x, y, np.cos(turned), np.sin(turned), *size, start.step + step, world)
                for step, (x, y, _, turned, _) in enumerate(way)
            ):
                return Plan(Status.FOUND, way, start.step, start.velocity, t[-1], tried)
        return Plan(Status.EXHAUSTED, expanded=tried, reason=Reason.UNREACHABLE)

    def _way(self, start: EgoState, middle: Floats, t: Floats) -> Floats:
        """The states at some times after the start, as in `Plan.trajectory`."""
        cos, sin = np.cos(start.heading), np.sin(start.heading)
        axes = np.array([[cos, sin], [-sin, cos]])  # Ahead, and to the left.
        ahead, aside = axes @ (middle - [start.x, start.y])
        needed = 2 * (ahead - start.velocity * t[-1]) / t[-1] ** 2
        a, s = np.clip(needed, -self.hardest, self.hardest), t / t[-1]
        way = np.stack([start.velocity * t + a * t**2 / 2, aside * s**3 * (10 - 15 * s + 6 * s**2)])
        u, v = start.velocity + a * t, aside * 30 * s**2 * (1 - s) ** 2 / t[-1]
        heading, speed = start.heading + np.arctan2(v, u), np.hypot(u, v)
        curvature = np.gradient(heading, t) / speed.clip(0.1)
        steering = np.arctan(BMW_320I.wheelbase * curvature)
        return np.column_stack([way.T @ axes + [start.x, start.y], speed, heading, steering])
