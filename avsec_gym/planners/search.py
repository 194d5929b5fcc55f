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

import numba
import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats
from avsec_gym.planners.collision import World, collides
from avsec_gym.planners.estimates import Limits, distance_to_goals, steps_to_goal, time_to_aim
from avsec_gym.planners.goal import GoalArrays, reaches
from avsec_gym.planners.primitives import PrimitiveArrays
from avsec_gym.planners.search_state import SearchState, pop, push, seen_before, turn

PAUSED, FOUND, EXHAUSTED = 0, 1, 2
"""What `search` returns."""


@numba.njit(nogil=True, cache=True)
def search(
    root: NDArray[np.int64],
    primitives: PrimitiveArrays,
    goals: GoalArrays,
    limits: Limits,
    reach: Floats,
    world: World,
    state: SearchState,
    budget: int,
    greedy: bool,
    reference: bool,
) -> int:
    """Expand up to ``budget`` nodes.

    Args:
        root: Primitives that the start may be followed by.
        primitives: The set.
        goals: At least one.
        limits: Vehicle and heuristic bounds.
        reach: Table of `avsec_gym.planners.reachability`; without rows, the bounds are used alone.
        world: What must not be touched.
        state: Nodes so far; node 0 is the start and, at first, the only one in the queue.
        budget: Most expansions in this call.
        greedy: GBFS instead of A*.
        reference: See the module's docstring.

    Returns:
        PAUSED (out of budget, nodes or table: call again with more), FOUND or EXHAUSTED.
    """
    counters = state.counters
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
        if not reference and seen_before(node, primitives, state):
            continue
        counters[2] += 1
        budget -= 1
        if node == 0:
            for k in range(root.shape[0]):
                _add_child(
                    node,
                    root[k],
                    primitives,
                    goals,
                    limits,
                    reach,
                    world,
                    state,
                    greedy,
                    reference,
                )
        else:
            own = state.primitive[node]
            for k in range(primitives.first_successor[own], primitives.first_successor[own + 1]):
                _add_child(
                    node,
                    primitives.successors[k],
                    primitives,
                    goals,
                    limits,
                    reach,
                    world,
                    state,
                    greedy,
                    reference,
                )
    return EXHAUSTED


@numba.njit(nogil=True, cache=True)
def _add_child(
    node: int,
    primitive: int,
    primitives: PrimitiveArrays,
    goals: GoalArrays,
    limits: Limits,
    reach: Floats,
    world: World,
    state: SearchState,
    greedy: bool,
    reference: bool,
) -> None:
    """Drive a primitive from a node; keep where it ends unless it collides or comes too late."""
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
            needed = steps_to_goal(x, y, heading, step, follow, distance, goals, limits, reach)
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
