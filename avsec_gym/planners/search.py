"""One best-first search over motion primitives, for A* and GBFS, in numba.

Two modes share the kernel:

* *reference* does what commonroad-search does, step for step: a tree search on ``f = g + h`` (or
  ``h``), with ``g`` the elapsed time and ``h`` the distance to the goal's axis-aligned box divided
  by the speed; no closed list, no horizon.
* *complete* searches the same space exhaustively: ``h`` never overestimates, states met before are
  not expanded again, and nodes that can no longer reach a goal in time are dropped.  Where it
  reports *exhausted*, no sequence of the given primitives reaches the goal.

A node is tested for collisions when it leaves the queue, not when it enters: the order of the
others is the same, and most nodes never leave it.

The kernel pauses when it runs out of the memory or expansions that it was given, so that its caller
can look at the clock, give it more, and go on where it stood.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel
from avsec_gym.planners.collision import CollisionWorld, collides
from avsec_gym.planners.estimates import (
    distance_to_goals,
    steps_by_air,
    steps_in_time,
    steps_to_goal,
    time_to_aim,
)
from avsec_gym.planners.problem import Problem
from avsec_gym.planners.search_state import (
    CLOSED,
    COS,
    ELAPSED,
    EXPANDED,
    GOAL,
    GOAL_NODE,
    HEADING,
    NODES,
    PARENT,
    PRIMITIVE,
    QUEUED,
    REFUSED,
    SIN,
    STEP,
    SearchState,
    X,
    Y,
    add_start,
    begin,
    closed_slot,
    grown,
    pop,
    push,
)
from avsec_gym.planners.sweep import drives_freely, edge_blocks, first_in_goal, may_meet, place_of
from avsec_gym.planners.trajectory import trajectory_to

PAUSED, FULL, FOUND, EXHAUSTED = range(4)
"""Results of `search`: out of budget, out of memory, at a goal, nothing left to expand.

The first two are pauses."""


@kernel(nogil=True)
def advance(
    asked: Any, world: tuple[Any, ...], memory: Any, budget: int, begins: bool
) -> tuple[int, Floats, float, int]:
    """Search on, as `search` does; how Python calls it.

    Args:
        asked: Handle on a `Problem`.
        world: A `CollisionWorld`, as a plain tuple, which numba reads in half the time.
        memory: Handle on a `SearchState`.
        budget: Most expansions in this call.
        begins: Whether what is in the memory is forgotten first.

    Returns:
        What `search` returns; the trajectory, shape (T, 5), without rows if nothing was found; its
        cost, seconds, nan if nothing was found; how many nodes are expanded.
    """
    problem, state = asked.content, memory.content
    if begins:
        begin(state)
    outcome = search(problem, CollisionWorld(*world), state, budget)
    expanded = state.counters[EXPANDED]
    if outcome != FOUND:
        return outcome, np.empty((0, 5)), np.nan, expanded
    goal = state.counters[GOAL_NODE]
    return outcome, trajectory_to(goal, problem, state), state.pose[goal, ELAPSED], expanded


@kernel(nogil=True)
def search_on(
    problem: Problem, world: CollisionWorld, state: SearchState, node_limit: int
) -> tuple[int, SearchState]:
    """Begin in given memory, and search to the end or a number of nodes.

    Returns:
        What `search` returns, and the memory, which may have grown.
    """
    begin(state)
    outcome = FULL
    while outcome == FULL:
        outcome = search(problem, world, state, node_limit - state.counters[EXPANDED])
        if outcome == FULL:
            state = grown(state, problem.primitives.end_class)
    return outcome, state


@kernel(nogil=True)
def search(problem: Problem, world: CollisionWorld, state: SearchState, budget: int) -> int:
    """Expand up to ``budget`` nodes.

    Args:
        problem: The planning problem.
        world: Obstacles and road edge, which must not be touched.
        state: Nodes so far; none at the beginning.
        budget: Most expansions in this call.

    Returns:
        PAUSED (out of budget) or FULL (out of memory): call again with more; FOUND or EXHAUSTED.

    Invariants, at the head of the loop, where it also pauses:

    * the queue holds all nodes that were made and not yet taken from it;
    * a node with children was tested: the way to it touches nothing; all others are tested when
      they leave the queue;
    * in complete mode the closed list holds one node for each expanded state, the start's aside.

    Behind the two checks there is memory for the children of one more node and one closed entry.
    """
    # Everything that the loop needs, taken out of its tuple once: to hand tuples of arrays on in
    # the loop copies them and counts references to each array, which cost more than the search.
    pose, link, keys, items, table = state.pose, state.link, state.key, state.item, state.table
    counters, root, reach = state.counters, problem.root, problem.reach
    goals, limits, offset = problem.goals, problem.limits, problem.limits.centre_offset
    windows, intervals, boxes = goals.steps, goals.intervals, goals.boxes
    reference, greedy, dt = problem.reference, problem.greedy, problem.limits.dt
    states, sweep = problem.primitives.states, problem.primitives.sweep
    steps, end_class = problem.primitives.steps, problem.primitives.end_class
    successors = problem.primitives.successors
    first_successor = problem.primitives.first_successor
    placed, blocks = np.empty((states.shape[1], 5)), edge_blocks(world.edges)
    room, slots = keys.shape[0] - problem.branching, table.shape[0]
    if counters[NODES] == 0:
        add_start(state, problem.start, problem.step, problem.at_goal)
    while counters[QUEUED] > 0:
        if budget <= 0:
            return PAUSED
        if counters[NODES] > room or 2 * (counters[CLOSED] + 1) > slots:
            return FULL
        node = pop(keys, items, counters[QUEUED])
        counters[QUEUED] -= 1
        step, own, goal_index = link[node, STEP], link[node, PRIMITIVE], link[node, GOAL]
        # The closed list: what was met before is done with.
        slot = -1
        if not reference and goal_index < 0 and node > 0:
            slot = closed_slot(node, end_class, pose, link, table)
            if slot < 0:
                continue
        # The way here, up to the goal; commonroad-search tests beyond it, too, but not the start.
        if node > 0:
            parent = link[node, PARENT]
            count = steps[own] if reference or goal_index < 0 else goal_index
            if not drives_freely(
                place_of(parent, pose, reference), link[parent, STEP], own, count, parent > 0,
                reference, states, sweep, limits, world, blocks, placed,
            ):  # fmt: skip
                link[node, GOAL] = REFUSED
                continue
        elif not reference and goal_index < 0 and _start_collides(problem, world):
            counters[EXPANDED] += 1
            return EXHAUSTED
        if goal_index >= 0:
            counters[GOAL_NODE] = node
            return FOUND
        if slot >= 0:
            table[slot] = node
            counters[CLOSED] += 1
        counters[EXPANDED] += 1
        budget -= 1
        # Its children: where every primitive leads that may follow.
        place, elapsed = place_of(node, pose, reference), pose[node, ELAPSED]
        x0, y0, heading0, cos0, sin0 = place
        first, last = 0, root.shape[0]
        if node > 0:
            first, last = first_successor[own], first_successor[own + 1]
        for k in range(first, last):
            p = successors[k] if node > 0 else root[k]
            driven = steps[p]
            # A primitive that meets a goal ends there.
            goal_index = -1
            if may_meet(x0, y0, cos0, sin0, step, p, driven, sweep, windows, intervals, boxes):
                goal_index = first_in_goal(place, step, p, driven, reference, offset, states, goals)
                if goal_index >= 0:
                    driven = goal_index
            px, py = states[p, driven, 0], states[p, driven, 1]
            x, y = cos0 * px - sin0 * py + x0, sin0 * px + cos0 * py + y0
            heading = heading0 + states[p, driven, 3]
            cos, sin = np.cos(heading), np.sin(heading)
            cx, cy = x + offset * cos, y + offset * sin
            # The key: f for A*, h for GBFS; nodes that cannot reach a goal in time are dropped.
            child_elapsed, child_step = elapsed + driven * dt, step + driven
            if reference:
                h = 0.0
                if goal_index < 0:
                    h = time_to_aim(cx, cy, states[p, driven, 2], child_step, goals)
                key = (h if greedy else child_elapsed + h) * 10000.0
            else:
                distance = distance_to_goals(cx, cy, boxes)
                needed = 0.0
                if goal_index < 0:
                    nearest = steps_by_air(distance, limits.step_distance)
                    needed = steps_in_time(nearest, child_step, windows)
                    if needed < np.inf and reach.shape[0] > 0:
                        needed = steps_to_goal(
                            x, y, heading, cos, sin, child_step, end_class[p], nearest, windows,
                            intervals, boxes, reach,
                        )  # fmt: skip
                    if needed == np.inf:
                        continue
                # Whole steps decide; among equals, the one nearer to the goal comes first.
                key = child_step + needed + 0.5 * distance / (1.0 + distance)
                if greedy:
                    key = 0.0 if goal_index >= 0 else distance
            # A node like all others, tested when it leaves the queue.
            new = counters[NODES]
            pose[new, X], pose[new, Y], pose[new, HEADING] = x, y, heading
            pose[new, COS], pose[new, SIN], pose[new, ELAPSED] = cos, sin, child_elapsed
            link[new, PARENT], link[new, PRIMITIVE] = node, p
            link[new, STEP], link[new, GOAL] = child_step, goal_index
            push(key, new, keys, items, counters[QUEUED])
            counters[NODES] += 1
            counters[QUEUED] += 1
    return EXHAUSTED


@kernel(nogil=True)
def refuse_the_rest(problem: Problem, world: CollisionWorld, state: SearchState) -> None:
    """Test the ways to all nodes, for pictures of the tree.

    The search tests none that is still in the queue, nor one whose state was expanded before.
    """
    pose, link, reference = state.pose, state.link, problem.reference
    steps, states = problem.primitives.steps, problem.primitives.states
    placed, blocks = np.empty((states.shape[1], 5)), edge_blocks(world.edges)
    # Invariant: the ways to all nodes before `node` are tested.
    for node in range(1, state.counters[NODES]):
        parent, own, goal_index = link[node, PARENT], link[node, PRIMITIVE], link[node, GOAL]
        if goal_index != REFUSED and not drives_freely(
            place_of(parent, pose, reference),
            link[parent, STEP],
            own,
            steps[own] if reference or goal_index < 0 else goal_index,
            parent > 0,
            reference,
            states,
            problem.primitives.sweep,
            problem.limits,
            world,
            blocks,
            placed,
        ):
            link[node, GOAL] = REFUSED


@kernel(nogil=True)
def _start_collides(problem: Problem, world: CollisionWorld) -> bool:
    """Whether the vehicle touches something before it moves."""
    x, y, heading = problem.start[0], problem.start[1], problem.start[2]
    limits, cos, sin = problem.limits, np.cos(heading), np.sin(heading)
    x, y = x + limits.centre_offset * cos, y + limits.centre_offset * sin
    half_length, half_width = limits.half_length, limits.half_width
    return collides(x, y, cos, sin, half_length, half_width, problem.step, world)
