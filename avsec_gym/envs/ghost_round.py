"""One scene with one driving intention, laid out for an attacker on detections."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats
from avsec_gym.metrics.safety import COLLISION, SAFE, UNPLANNED
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.builder import GOAL_STEPS
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.planning_scenario import PlanningScenario
from avsec_gym.scenario.scene import Motion, Scene

OUTCOMES = (SAFE, COLLISION, UNPLANNED)
NEAREST = 32
"""Objects in an observation."""
FEATURES = 8
"""Features of each object: present, x, y, cos, sin of the heading, length, width, moving."""

SCENE_SIZE = 8 + FEATURES * NEAREST
"""Numbers on start, goal and objects, with which an observation begins."""

_TIME_STEPS = GOAL_STEPS[1] + 1
_SCALE = np.array([1.0, 50.0, 20.0, 1.0, 1.0, 10.0, 4.0, 1.0])


class Queried(NamedTuple):
    """What became of a query in each of B rounds."""

    outcome: NDArray[np.int64]
    """Row of `OUTCOMES`, shape (B,)."""
    cost: Floats
    """Planned time to the goal, s, nan if unplanned as the next three, shape (B,)."""
    path_length: Floats
    """m, shape (B,)."""
    smallest_distance: Floats
    """Smallest distance of the car from anything real at a time step, m, shape (B,)."""
    cost_sm1: Floats
    """CommonRoad's SM1, shape (B,)."""
    ghosts: NDArray[np.int64]
    """Placed, shape (B,)."""
    hidden: NDArray[np.int64]
    """Objects hidden, shape (B,)."""

    @classmethod
    def nothing(cls, count: int) -> Queried:
        """The state before the first query: outcomes of -1."""
        return cls(np.full(count, -1), *np.full((4, count), np.nan), *np.zeros((2, count), int))


@dataclass(frozen=True, eq=False)
class Round:
    """One scene with one intention, laid out for planning and judging."""

    index: int
    """The scene's place in its set."""
    scene: Scene
    intention: Intention
    problem: PlanningScenario
    poses: Floats
    """Real obstacles from near to far, x, y, cos, sin at every time step, shape (N, T, 4);
    T is 1 where nothing moves."""
    believed: Floats
    """The same as the planner believes them to move, shape (N, T, 4)."""
    half_sizes: Floats
    """Shape (N, 2)."""
    features: NDArray[np.float32]
    """The observation's part on start, goal and objects."""
    kind: tuple[Any, ...]
    """Rounds of one kind differ in their obstacles only."""


def round_of(index: int, scene: Scene, intention: Intention, motion: Motion) -> Round:
    """A scene with an intention, laid out.

    Args:
        index: The scene's place in its set.
        scene: The scene, with what is really there.
        intention: The lane that the car wants to reach.
        motion: How much the planner knows of moving objects.
    """
    problem, truth = scene.problem(intention, motion=motion), scene.truth()
    order = np.argsort(np.hypot(*truth.poses[:, 0, :2].T), kind="stable")
    half_sizes = 0.5 * np.array([(s.length, s.width) for s in truth.shapes]).reshape(-1, 2)[order]  # type: ignore[union-attr]
    moving = ~truth.static[order]
    # Where nothing moves, one time step stands for all.
    steps = _TIME_STEPS if moving.any() else 1
    poses = _tracks(truth.poses[order], steps)
    start, goal = problem.start, problem.goals[0].region[0]  # type: ignore[index]
    head = [start.velocity / 15.0, float(scene.road_type == RoadType.HIGHWAY)]
    head += [float(intention == each) for each in Intention]
    head += [goal.x / 50.0, goal.y / 20.0, min(1.0, len(order) / NEAREST)]  # type: ignore[union-attr]
    rows = np.zeros((NEAREST, FEATURES))
    seen = min(NEAREST, len(order))
    rows[:seen, 0] = 1.0
    rows[:seen, 1:5] = poses[:seen, 0]
    rows[:seen, 5:7] = 2.0 * half_sizes[:seen]
    rows[:seen, 7] = moving[:seen]
    return Round(
        index,
        scene,
        intention,
        problem,
        poses,
        _tracks(problem.obstacles.poses[order], steps),
        half_sizes,
        np.concatenate([head, np.clip(rows / _SCALE, -1.0, 1.0).ravel()]).astype(np.float32),
        kind=(scene.road_type, intention, start.velocity, steps, scene.own_road),
    )


def _tracks(poses: Floats, steps: int) -> Floats:
    """x, y, cos, sin at so many time steps, the last known pose kept."""
    track = np.repeat(poses[:, -1:], steps, axis=1)
    track[:, : poses.shape[1]] = poses[:, :steps]
    return np.concatenate([track[..., :2], np.cos(track[..., 2:]), np.sin(track[..., 2:])], axis=-1)


def observation(
    rounds: Sequence[Round],
    outcomes: NDArray[np.int64],
    costs: Floats,
    left: Floats,
    tail: Floats,
) -> NDArray[np.float32]:
    """Scene, outcome, planned time / 3 s, share of queries left, and what a game adds.

    Args:
        rounds: The B rounds that are observed.
        outcomes: Outcomes of the last queries, as of `GhostGame.observe`, as the next two.
        costs: Planned times, s, shape (B,).
        left: Shares of the queries left, shape (B,).
        tail: Numbers that the game adds, shape (B, M).

    Returns:
        Shape (B, SCENE_SIZE + 5 + M), float32.
    """
    out = np.zeros((len(rounds), SCENE_SIZE + 5 + tail.shape[1]), np.float32)
    out[:, :SCENE_SIZE] = [r.features for r in rounds]
    asked = np.nonzero(outcomes >= 0)[0]
    out[asked, SCENE_SIZE + outcomes[asked]] = 1.0
    out[:, SCENE_SIZE + 3] = np.where(np.isnan(costs), 0.0, np.minimum(costs / 3.0, 1.0))
    out[:, SCENE_SIZE + 4] = np.maximum(left, 0.0)
    out[:, SCENE_SIZE + 5 :] = tail
    return out
