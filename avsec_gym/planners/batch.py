"""Many planning problems in one call of the search kernel: what vectorised environments stand on.

All problems share start, goal and primitives; they differ in their obstacles, which are rectangles.
The answers are those of `MotionPrimitivePlanner` in complete mode, node for node.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel
from avsec_gym.planners.collision import FOR_EVER, CollisionWorld
from avsec_gym.planners.problem import Problem
from avsec_gym.planners.search import FOUND, search_on
from avsec_gym.planners.search_state import ELAPSED, EXPANDED, GOAL_NODE, new_state
from avsec_gym.planners.trajectory import trajectory_to


class RectangleTracks(NamedTuple):
    """Rectangles of B problems on their way, N for each; those far away fill up the rows."""

    half_sizes: Floats
    """Half length and half width, shape (B, N, 2)."""
    poses: Floats
    """x, y, cos, sin of the heading at steps 0..T-1, the last one kept after, (B, N, T, 4)."""


class BatchPlans(NamedTuple):
    """Answers to B problems."""

    found: NDArray[np.bool_]
    """Shape (B,)."""
    lengths: NDArray[np.int64]
    """Number of states; 0 where nothing was found, shape (B,)."""
    trajectories: Floats
    """Centre x, y, velocity, heading, steering angle, shape (B, T, 5); rows beyond the length
    repeat the last state."""
    cost: Floats
    """Seconds to the goal; nan where nothing was found, shape (B,)."""
    expanded: NDArray[np.int64]
    """Shape (B,)."""


def plan_batch(
    problem: Problem, longest: int, edges: Floats, tracks: RectangleTracks, node_limit: int
) -> BatchPlans:
    """Plan B problems that differ in their obstacles only.

    Args:
        problem: The part of the problem that all share; not in reference mode.
        longest: Most states of a trajectory.
        edges: Segments of the road edge, shape (M, 4).
        tracks: The obstacles, from time step 0 on.
        node_limit: Most nodes to expand for each.
    """
    return BatchPlans(*_search_all(problem, longest, edges.copy(), tracks, node_limit))


@kernel(nogil=True)
def _search_all(
    problem: Problem, longest: int, edges: Floats, tracks: RectangleTracks, node_limit: int
) -> tuple[NDArray[np.bool_], NDArray[np.int64], Floats, Floats, NDArray[np.int64]]:
    """The fields of `BatchPlans`.

    Invariant: memory is shared by all problems; the first `near` rows belong to the present one.
    Rows are copied element by element: assignments of slices are compiled three times as long.
    """
    limits, start = problem.limits, problem.start
    count, rows, known = tracks.poses.shape[0], tracks.poses.shape[1], tracks.poses.shape[2]
    found, lengths = np.zeros(count, np.bool_), np.zeros(count, np.int64)
    trajectories = np.zeros((count, longest, 5))
    cost, expanded = np.full(count, np.nan), np.zeros(count, np.int64)
    # Memory that all problems share; `near` rows of it are in use.
    fresh = new_state(1024, 2048)
    vertices, sizes = np.empty((rows, 4, 2)), np.zeros((rows, 2))
    poses = np.empty((rows, known, 4))
    corners = np.full(rows, 4)
    presence = np.empty((rows, 3), np.int64)
    presence[:, 0], presence[:, 1], presence[:, 2] = 0, known, FOR_EVER
    farthest = longest * limits.step_distance + 2.0 * limits.half_length
    for b in range(count):
        # Lay out the rectangles that the vehicle can come near to.
        near = 0
        for i in range(rows):
            half_length, half_width = tracks.half_sizes[b, i, 0], tracks.half_sizes[b, i, 1]
            sizes[near, 1] = np.sqrt(half_length**2 + half_width**2)
            limit = farthest + sizes[near, 1]
            for t in range(known):
                x, y = tracks.poses[b, i, t, 0] - start[0], tracks.poses[b, i, t, 1] - start[1]
                if x * x + y * y <= limit * limit:
                    break
            else:
                continue
            for k in range(4):
                vertices[near, k, 0] = half_length if k == 0 or k == 3 else -half_length
                vertices[near, k, 1] = half_width if k < 2 else -half_width
            for t in range(known):
                for k in range(4):
                    poses[near, t, k] = tracks.poses[b, i, t, k]
            near += 1
        world = CollisionWorld(
            vertices[:near],
            corners[:near],
            sizes[:near],
            poses[:near],
            presence[:near],
            edges,
        )
        # Search, and keep the trajectory.
        outcome, state = search_on(problem, world, fresh, node_limit)
        expanded[b] = state.counters[EXPANDED]
        if outcome == FOUND:
            node = state.counters[GOAL_NODE]
            driven = trajectory_to(node, problem, state)
            found[b], lengths[b], cost[b] = True, driven.shape[0], state.pose[node, ELAPSED]
            for t in range(longest):
                for k in range(5):
                    trajectories[b, t, k] = driven[min(t, driven.shape[0] - 1), k]
    return found, lengths, trajectories, cost, expanded
