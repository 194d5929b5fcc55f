"""All that a car can do in the next two seconds: the chains of motion primitives from its start.

The planner picks one of them; measures that ask how a belief changes what the car would do need all
of them, and how much the planner likes each.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats, wrap_angle
from avsec_gym.metrics.collision_check import TrajectoryBatch, batch_collides, present_poses
from avsec_gym.planners.primitives import MotionPrimitives, suitable_primitives
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.planning_scenario import EgoState, Goal, PlanningScenario
from avsec_gym.scenario.shapes import Rectangle

CHAIN = 4
"""Primitives in a chain, of half a second each: two seconds bring a car to its goal, 15 m ahead."""
_AWAY = 1e6
"""Metres: where objects are put that are not there yet."""


@dataclass(frozen=True, eq=False)
class TrajectoryBundle:
    """B trajectories from one start, in one scenario without its obstacles.

    Chains share their beginnings: what many trajectories have in common is kept, and checked, once.

    Args:
        nodes: The distinct states, each at its own time step, as of `Plan.trajectory`, shape
            (U, 5).
        steps: Number of time steps after the start of each node, shape (U,).
        index: Node of each trajectory at each time step, shape (B, T).
        lengths: Number of states up to the first one that is in the goal, or all, shape (B,).
        cost: Cost-to-go as A* counts it, shape (B,), seconds: time to the goal, or else the time
            of all states and that to drive from there to the goal region as the crow flies.
    """

    nodes: Floats
    steps: NDArray[np.int64]
    index: NDArray[np.int64]
    lengths: NDArray[np.int64]
    cost: Floats

    @property
    def states(self) -> Floats:
        """The states of each trajectory, shape (B, T, 5)."""
        return self.nodes[self.index]

    def touching(self, scenario: PlanningScenario) -> NDArray[np.bool_]:
        """Which trajectories touch an obstacle before they are in the goal, shape (B,).

        Args:
            scenario: A scenario with rectangles as obstacles.
        """
        obstacles, count = scenario.obstacles, self.index.shape[1]
        if not len(obstacles):
            return np.zeros(len(self.index), bool)
        poses, half_sizes = _laid_out(obstacles, count, scenario.start.step)
        there = poses[self.steps if len(poses) > 1 else np.zeros_like(self.steps)]
        batch = TrajectoryBatch(
            self.nodes[:, None],
            np.ones(len(self.nodes), np.int64),
            there[:, :, None],
            np.repeat(half_sizes[None], len(self.nodes), axis=0),
        )
        touched = batch_collides(batch, suitable_primitives(scenario).vehicle)[self.index]
        before = np.arange(count) < self.lengths[:, None]
        return np.asarray((touched & before).any(axis=1))


def trajectory_bundle(scenario: PlanningScenario, chain: int = CHAIN) -> TrajectoryBundle:
    """All trajectories of so many primitives, whatever stands in their way.

    Args:
        scenario: Start, goal and road type count; obstacles and the road edge do not.
        chain: Number of primitives of each.
    """
    primitives, (goal,) = suitable_primitives(scenario), scenario.goals
    nodes, steps, index = _chains(primitives, scenario.start, chain)
    in_goal = _in_goal(nodes, scenario.start.step + steps, goal)[index]
    reaches = in_goal.any(axis=1)
    last = np.where(reaches, in_goal.argmax(axis=1), index.shape[1] - 1)
    (region,) = goal.region or (None,)
    assert isinstance(region, Rectangle), "goal regions are rectangles"
    fastest = float(primitives.states[..., 2].max())
    away = _distance(nodes[index[:, -1], :2], region) / fastest
    cost = last * scenario.dt + np.where(reaches, 0.0, away)
    return TrajectoryBundle(nodes, steps, index, last + 1, cost)


@lru_cache(maxsize=8)
def _chains(
    primitives: MotionPrimitives, start: EgoState, chain: int
) -> tuple[Floats, NDArray[np.int64], NDArray[np.int64]]:
    """States of the vehicle's centre, their time steps, and those of every chain: see above.

    Invariant: row i of `index` holds the nodes of a chain so far, and `last` its last primitive.
    """
    offset = primitives.vehicle.rear_axle
    cos, sin = np.cos(start.heading), np.sin(start.heading)
    # Rear axle and heading at the end of each chain so far.
    pose = np.array([[start.x - offset * cos, start.y - offset * sin, start.heading]])
    last = primitives.starting_at(start.velocity, start.steering_angle)
    pose, index = np.repeat(pose, len(last), axis=0), np.zeros((len(last), 0), np.int64)
    nodes, steps, known = [], [], 0
    for number in range(chain):
        if number:
            chains, following = np.nonzero(primitives.follows[last])
            pose, index, last = pose[chains], index[chains], following
        own = primitives.states[last]
        cos, sin = np.cos(pose[:, 2, None]), np.sin(pose[:, 2, None])
        turned = own.copy()
        turned[..., 0] = pose[:, 0, None] + cos * own[..., 0] - sin * own[..., 1]
        turned[..., 1] = pose[:, 1, None] + sin * own[..., 0] + cos * own[..., 1]
        turned[..., 3] += pose[:, 2, None]
        pose = turned[:, -1, [0, 1, 3]]
        # Each begins where the one before it ends.
        new = turned[:, 1 if number else 0 :]
        fresh = known + np.arange(new.shape[0] * new.shape[1]).reshape(new.shape[:2])
        nodes.append(new.reshape(-1, 5))
        steps.append(np.tile(index.shape[1] + np.arange(new.shape[1]), len(new)))
        known, index = known + fresh.size, np.hstack([index, fresh])
    everything = np.concatenate(nodes)
    everything[:, 0] += offset * np.cos(everything[:, 3])
    everything[:, 1] += offset * np.sin(everything[:, 3])
    return everything, np.concatenate(steps), index


def _in_goal(states: Floats, step: NDArray[np.int64], goal: Goal) -> NDArray[np.bool_]:
    """Which states at these time steps are in the goal, shape (U,)."""
    (region,) = goal.region or (None,)
    result = (step >= goal.steps[0]) & (step <= goal.steps[1])
    if isinstance(region, Rectangle):
        result &= _distance(states[..., :2], region) == 0
    if goal.heading is not None:
        middle, half = np.mean(goal.heading), 0.5 * np.ptp(goal.heading)
        result &= np.abs(wrap_angle(states[..., 3] - middle)) <= half + 1e-9
    if goal.velocity is not None:
        low, high = goal.velocity
        result &= (states[..., 2] >= low - 1e-9) & (states[..., 2] <= high + 1e-9)
    return result


def _distance(points: Floats, region: Rectangle) -> Floats:
    """Metres from points to a rectangle, 0 inside."""
    dx, dy = points[..., 0] - region.x, points[..., 1] - region.y
    cos, sin = np.cos(region.heading), np.sin(region.heading)
    ahead = np.maximum(np.abs(cos * dx + sin * dy) - 0.5 * region.length, 0.0)
    aside = np.maximum(np.abs(cos * dy - sin * dx) - 0.5 * region.width, 0.0)
    return np.hypot(ahead, aside)


def _laid_out(obstacles: Obstacles, count: int, first_step: int) -> tuple[Floats, Floats]:
    """Poses x, y, cos, sin of rectangles, shape (T or 1, N, 4), and half sizes, shape (N, 2)."""
    present, poses = present_poses(count, obstacles, first_step)
    laid = np.concatenate([poses[..., :2], np.cos(poses[..., 2:]), np.sin(poses[..., 2:])], axis=-1)
    laid[~present, :2] = _AWAY
    sizes = []
    for shape in obstacles.shapes:
        assert isinstance(shape, Rectangle), "obstacles of boxes are rectangles"
        sizes.append((0.5 * shape.length, 0.5 * shape.width))
    return (laid[:1] if obstacles.static.all() else laid), np.array(sizes)
