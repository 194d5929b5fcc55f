"""One best-first search over motion primitives, for A* and GBFS, in numba.

Two modes share the kernel:

* *reference* does what commonroad-search does, step for step: a tree search on ``f = g + h`` (or
  ``h``), with ``g`` the elapsed time and ``h`` the distance to the goal's axis-aligned box divided
  by the speed; no closed list, no horizon.
* *complete* searches the same space exhaustively: ``h`` never overestimates, states met before are
  not expanded again, and nodes that can no longer reach a goal in time are dropped.  Where it
  reports *exhausted*, no sequence of the given primitives reaches the goal.

The kernel pauses when it runs out of the memory or expansions that it was given, so that its caller
can look at the clock, give it more, and go on.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats
from avsec_gym.planners.collision import World, collides
from avsec_gym.planners.estimates import Limits, distance_to_goals, steps_to_goal, time_to_aim
from avsec_gym.planners.goal import GoalArrays, reaches
from avsec_gym.planners.primitives import PrimitiveArrays
from avsec_gym.planners.search_state import (
    SearchState,
    begin,
    grown,
    new_state,
    pop,
    push,
    seen_before,
    turn,
)

PAUSED, FOUND, EXHAUSTED = 0, 1, 2
"""What `search` returns."""


class Problem(NamedTuple):
    """Everything that a search needs to know but the obstacles."""

    root: NDArray[np.int64]
    """Primitives that may follow the start."""
    primitives: PrimitiveArrays
    goals: GoalArrays
    limits: Limits
    reach: Floats
    """Table of `avsec_gym.planners.reachability`; without rows, other bounds are used alone."""
    start: Floats
    """Rear-axle x, y, heading, shape (3,)."""
    speed: float
    """The speed that the primitives start with, m/s."""
    steering_angle: float
    """The steering angle that they start with, rad."""
    step: int
    """Time step of the start."""
    at_goal: bool
    """The start is a goal state already."""
    greedy: bool
    """GBFS instead of A*."""
    reference: bool
    """See the module's docstring."""


@numba.njit(nogil=True, cache=True)
def solve(problem: Problem, world: World, node_limit: int) -> tuple[int, Floats, float, int]:
    """Search from the start to the end, or until a number of nodes is expanded.

    Args:
        problem: What is asked.
        world: What must not be touched.
        node_limit: Most expansions.

    Returns:
        PAUSED (at the limit), FOUND or EXHAUSTED; the trajectory, shape (T, 5), without rows where
        nothing was found; the seconds that it takes; the number of nodes expanded.
    """
    state = new_state(1024, 2048)
    outcome, state = search_on(problem, world, state, node_limit)
    expanded = state.counters[2]
    if outcome != FOUND:
        return outcome, np.empty((0, 5)), np.nan, expanded
    node = state.counters[3]
    return outcome, trajectory_to(node, problem, state), state.elapsed[node], expanded


@numba.njit(nogil=True, cache=True)
def search_on(
    problem: Problem, world: World, state: SearchState, node_limit: int
) -> tuple[int, SearchState]:
    """Begin in given memory, and search as `solve` does; the memory may have grown."""
    begin(state, problem.start, problem.speed, problem.step, problem.at_goal)
    outcome = PAUSED
    while outcome == PAUSED and state.counters[2] < node_limit:
        outcome = search(problem, world, state, node_limit - state.counters[2])
        if outcome == PAUSED:
            state = grown(state, problem.primitives)
    return outcome, state


@numba.njit(nogil=True, cache=True)
def search(problem: Problem, world: World, state: SearchState, budget: int) -> int:
    """Expand up to ``budget`` nodes.

    Args:
        problem: What is asked.
        world: What must not be touched.
        state: Nodes so far; `begin` has put the start there.
        budget: Most expansions in this call.

    Returns:
        PAUSED (out of budget, nodes or table: call again with more), FOUND or EXHAUSTED.
    """
    counters, primitives, root = state.counters, problem.primitives, problem.root
    branching = root.shape[0]
    for i in range(primitives.steps.shape[0]):
        branching = max(
            branching, primitives.first_successor[i + 1] - primitives.first_successor[i]
        )
    while counters[1] > 0:
        if (
            budget == 0
            or counters[0] + branching > state.parent.shape[0]
            or 2 * (counters[4] + 1) > state.table.shape[0]
        ):
            return PAUSED
        node = pop(state)
        if state.goal_index[node] >= 0:
            counters[3] = node
            return FOUND
        if not problem.reference and seen_before(node, primitives, state):
            continue
        counters[2] += 1
        budget -= 1
        if node == 0:
            if not problem.reference and _start_collides(problem, world):
                return EXHAUSTED
            for k in range(root.shape[0]):
                _add_child(node, root[k], problem, world, state)
        else:
            own = state.primitive[node]
            for k in range(primitives.first_successor[own], primitives.first_successor[own + 1]):
                _add_child(node, primitives.successors[k], problem, world, state)
    return EXHAUSTED


@numba.njit(nogil=True, cache=True)
def _start_collides(problem: Problem, world: World) -> bool:
    x, y, heading = problem.start[0], problem.start[1], problem.start[2]
    limits, cos, sin = problem.limits, np.cos(heading), np.sin(heading)
    x, y = x + limits.centre_offset * cos, y + limits.centre_offset * sin
    half_length, half_width = limits.half_length, limits.half_width
    return collides(x, y, cos, sin, half_length, half_width, problem.step, world)


@numba.njit(nogil=True, cache=True)
def _add_child(
    node: int, primitive: int, problem: Problem, world: World, state: SearchState
) -> None:
    """Drive a primitive from a node; keep where it ends unless it collides or comes too late."""
    primitives, goals, limits = problem.primitives, problem.goals, problem.limits
    reference, greedy = problem.reference, problem.greedy
    x0, y0, heading0 = state.pose[node, 0], state.pose[node, 1], state.pose[node, 2]
    cos0, sin0 = turn(heading0, reference)
    start_step = state.step[node]
    count = primitives.steps[primitive]
    x, y, heading, velocity = x0, y0, heading0, state.velocity[node]
    goal_index = -1
    for j in range(1, count + 1):
        px, py = primitives.states[primitive, j, 0], primitives.states[primitive, j, 1]
        x, y = cos0 * px - sin0 * py + x0, sin0 * px + cos0 * py + y0
        heading = heading0 + primitives.states[primitive, j, 3]
        velocity = primitives.states[primitive, j, 2]
        pc, ps = primitives.cos[primitive, j], primitives.sin[primitive, j]
        cos, sin = cos0 * pc - sin0 * ps, sin0 * pc + cos0 * ps
        if reference:
            cos, sin = np.cos(heading), np.sin(heading)
        cx, cy = x + limits.centre_offset * cos, y + limits.centre_offset * sin
        step = start_step + j
        if collides(cx, cy, cos, sin, limits.half_length, limits.half_width, step, world):
            return
        if goal_index < 0 and reaches(cx, cy, heading, velocity, step, goals):
            goal_index = j
            if not reference:
                break
    driven = count
    if goal_index >= 0:
        driven = goal_index
        # Past the goal only the collision test looked.
        px, py = primitives.states[primitive, driven, 0], primitives.states[primitive, driven, 1]
        x, y = cos0 * px - sin0 * py + x0, sin0 * px + cos0 * py + y0
        heading = heading0 + primitives.states[primitive, driven, 3]
        velocity = primitives.states[primitive, driven, 2]
    step = start_step + driven
    elapsed = state.elapsed[node] + driven * limits.dt
    cx = x + limits.centre_offset * np.cos(heading)
    cy = y + limits.centre_offset * np.sin(heading)
    key = 0.0
    if reference:
        h = 0.0 if goal_index >= 0 else time_to_aim(cx, cy, velocity, step, goals)
        key = (h if greedy else elapsed + h) * 10000.0
    else:
        distance = distance_to_goals(cx, cy, goals)
        needed = 0.0
        if goal_index < 0:
            follow = primitives.end_class[primitive]
            needed = steps_to_goal(
                x, y, heading, step, follow, distance, goals, limits, problem.reach
            )
            if needed == np.inf:
                return
        if greedy:
            key = 0.0 if goal_index >= 0 else distance
        else:
            # Whole steps decide; among equals, the one nearer to the goal comes first.
            key = step + needed + 0.5 * distance / (1.0 + distance)
    new = state.counters[0]
    state.counters[0] += 1
    state.pose[new, 0], state.pose[new, 1], state.pose[new, 2] = x, y, heading
    state.elapsed[new], state.velocity[new] = elapsed, velocity
    state.parent[new], state.primitive[new] = node, primitive
    state.step[new], state.goal_index[new] = step, goal_index
    push(state, key, new)


@numba.njit(nogil=True, cache=True)
def trajectory_to(node: int, problem: Problem, state: SearchState) -> Floats:
    """States from the start to a node as centre x, y, velocity, heading, steering angle.

    Args:
        node: Where the way ends.
        problem: Whose primitives were driven.
        state: The nodes.

    Returns:
        Shape (T, 5).
    """
    primitives, centre_offset = problem.primitives, problem.limits.centre_offset
    states = np.empty((state.step[node] - state.step[0] + 1, 5))
    child = node
    while state.parent[child] >= 0:
        parent = state.parent[child]
        x, y, heading = state.pose[parent, 0], state.pose[parent, 1], state.pose[parent, 2]
        cos, sin = turn(heading, problem.reference)
        before = state.step[parent] - state.step[0]
        for j in range(1, state.step[child] - state.step[parent] + 1):
            own = primitives.states[state.primitive[child], j]
            row = states[before + j]
            row[0], row[1] = cos * own[0] - sin * own[1] + x, sin * own[0] + cos * own[1] + y
            row[2], row[3], row[4] = own[2], heading + own[3], own[4]
        child = parent
    row = states[0]
    row[0], row[1], row[3] = state.pose[0, 0], state.pose[0, 1], state.pose[0, 2]
    row[2], row[4] = state.velocity[0], problem.steering_angle
    for t in range(states.shape[0]):
        states[t, 0] += centre_offset * np.cos(states[t, 3])
        states[t, 1] += centre_offset * np.sin(states[t, 3])
    return states
