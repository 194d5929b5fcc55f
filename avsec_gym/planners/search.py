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
from avsec_gym.planners.primitives import PrimitiveArrays

PAUSED, FOUND, EXHAUSTED = 0, 1, 2
"""What `search` returns."""

_QUANTUM = 1e-6
"""States that agree to this (m, rad) are one state to the closed list."""


class GoalArrays(NamedTuple):
    """Goal regions, laid out for the kernel; one row of `pieces` for each convex piece."""

    steps: NDArray[np.int64]
    """First and last time step, shape (G, 2)."""
    heading: Floats
    """Start of the interval and its width, shape (G, 2); a width of 2 pi or more is any heading."""
    velocity: Floats
    """Interval, shape (G, 2)."""
    anywhere: NDArray[np.bool_]
    """No region is asked for, shape (G,)."""
    vertices: Floats
    """Convex pieces, counter-clockwise, shape (Q, K, 2)."""
    corners: NDArray[np.int64]
    """Vertices in use, shape (Q,); a single one is a disc."""
    radius: Floats
    """Shape (Q,)."""
    owner: NDArray[np.int64]
    """Goal that each piece belongs to, shape (Q,)."""
    boxes: Floats
    """x_min, x_max, y_min, y_max of each goal's region, shape (G, 4)."""
    aim: Floats
    """The box that reference mode steers for, shape (4,)."""


class Limits(NamedTuple):
    """The ego vehicle and what bounds the heuristic."""

    half_length: float
    half_width: float
    centre_offset: float
    """From the rear axle to the centre, along the heading."""
    dt: float
    step_distance: float
    """No primitive moves the centre farther than this in one time step."""


class SearchState(NamedTuple):
    """Nodes, queue and closed list; grown by the caller."""

    pose: Floats
    """Rear axle x, y and heading at each node, shape (N, 3)."""
    elapsed: Floats
    """Priority g in seconds, shape (N,)."""
    velocity: Floats
    parent: NDArray[np.int64]
    primitive: NDArray[np.int64]
    step: NDArray[np.int64]
    goal_index: NDArray[np.int64]
    """States of the primitive up to the goal; -1 where it holds none, shape (N,)."""
    key: Floats
    """Binary heap: priorities, shape (N,)."""
    item: NDArray[np.int64]
    """Binary heap: nodes, shape (N,); a node's number is its insertion number."""
    table: NDArray[np.int64]
    """Closed list: open-addressing hash table of nodes, -1 where free; a power of two long."""
    counters: NDArray[np.int64]
    """Nodes, heap size, expanded, goal node, entries in the closed list."""


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
        node = _pop(state)
        if state.goal_index[node] >= 0:
            counters[3] = node
            return FOUND
        if not reference and _seen_before(node, primitives, state):
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
        cx, cy = x + limits.centre_offset * cos, y + limits.centre_offset * sin
        step = start_step + j
        if collides(
            cx, cy, cos, sin, limits.half_length, limits.half_width, step, world
        ):
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
        h = 0.0 if goal_index >= 0 else _time_to_aim(cx, cy, velocity, step, goals)
        key = (h if greedy else elapsed + h) * 10000.0
    else:
        distance = _distance_to_goals(cx, cy, goals)
        needed = 0.0
        if goal_index < 0:
            follow = primitives.end_class[primitive]
            needed = _steps_to_goal(x, y, heading, step, follow, distance, goals, limits, reach)
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
    _push(state, key, new)


@numba.njit(nogil=True, cache=True)
def turn(heading: float, reference: bool) -> tuple[float, float]:
    """Cosine and sine by which a primitive is turned into its place.

    Up to 0.05 rad commonroad-io takes 1 and the angle, and so reference mode does.
    """
    if reference:
        heading = np.fmod(heading, 2.0 * np.pi)
        if abs(heading) <= 0.05:
            return 1.0, heading
    return np.cos(heading), np.sin(heading)


@numba.njit(nogil=True, cache=True)
def reaches(
    x: float, y: float, heading: float, velocity: float, step: int, goals: GoalArrays
) -> bool:
    """Whether a vehicle with its centre at (x, y) is in a goal region; borders belong to it."""
    for g in range(goals.steps.shape[0]):
        if step < goals.steps[g, 0] or step > goals.steps[g, 1]:
            continue
        if velocity < goals.velocity[g, 0] or velocity > goals.velocity[g, 1]:
            continue
        turned = (heading - goals.heading[g, 0]) % (2.0 * np.pi)
        if turned > goals.heading[g, 1]:
            continue
        if goals.anywhere[g]:
            return True
        for q in range(goals.owner.shape[0]):
            if goals.owner[q] == g and _in_piece(x, y, q, goals):
                return True
    return False


@numba.njit(nogil=True, cache=True)
def _in_piece(x: float, y: float, q: int, goals: GoalArrays) -> bool:
    count = goals.corners[q]
    if count == 1:
        dx, dy = x - goals.vertices[q, 0, 0], y - goals.vertices[q, 0, 1]
        return np.sqrt(dx * dx + dy * dy) <= goals.radius[q]
    for k in range(count):
        following = k + 1 if k + 1 < count else 0
        ax, ay = goals.vertices[q, k, 0], goals.vertices[q, k, 1]
        ex, ey = goals.vertices[q, following, 0] - ax, goals.vertices[q, following, 1] - ay
        if ex * (y - ay) - ey * (x - ax) < 0.0:
            return False
    return True


@numba.njit(nogil=True, cache=True)
def _distance_to_box(x: float, y: float, x1: float, x2: float, y1: float, y2: float) -> float:
    dx = 0.0 if x1 <= x <= x2 else min(abs(x1 - x), abs(x2 - x))
    dy = 0.0 if y1 <= y <= y2 else min(abs(y1 - y), abs(y2 - y))
    return np.sqrt(dx * dx + dy * dy)


@numba.njit(nogil=True, cache=True)
def _time_to_aim(x: float, y: float, velocity: float, step: int, goals: GoalArrays) -> float:
    """commonroad-search's heuristic: seconds to the first goal's box at the present speed."""
    if goals.anywhere[0]:
        return float(goals.steps[0, 0] - step)
    if abs(velocity) <= 1e-8:
        return np.inf
    aim = goals.aim
    return _distance_to_box(x, y, aim[0], aim[1], aim[2], aim[3]) / velocity


@numba.njit(nogil=True, cache=True)
def _distance_to_goals(x: float, y: float, goals: GoalArrays) -> float:
    """Distance of the centre to the nearest goal's box."""
    best = np.inf
    for g in range(goals.steps.shape[0]):
        box = goals.boxes[g]
        best = min(best, _distance_to_box(x, y, box[0], box[1], box[2], box[3]))
    return best


@numba.njit(nogil=True, cache=True)
def _steps_to_goal(
    x: float,
    y: float,
    heading: float,
    step: int,
    follow: int,
    distance: float,
    goals: GoalArrays,
    limits: Limits,
    reach: Floats,
) -> float:
    """Time steps that any way from a rear-axle pose to any goal needs at least.

    Whole steps; inf where every goal comes too late.  ``distance`` is the centre's to the nearest
    goal.
    """
    nearest = 1.0
    if distance > 0.0:
        nearest = np.inf
        if limits.step_distance > 0.0:
            nearest = max(1.0, np.ceil(distance / limits.step_distance - 1e-9))
    best = np.inf
    cos, sin = np.cos(heading), np.sin(heading)
    for g in range(goals.steps.shape[0]):
        soonest = max(nearest, float(goals.steps[g, 0] - step))
        latest = goals.steps[g, 1] - step
        if soonest > latest or soonest >= best:
            continue
        if reach.shape[0] == 0:
            best = soonest
            continue
        for j in range(int(soonest), latest + 1):
            if j >= best:
                break
            if _may_reach(x, y, heading, cos, sin, reach[follow, j], g, goals):
                best = float(j)
    return best


@numba.njit(nogil=True, cache=True)
def _may_reach(
    x: float,
    y: float,
    heading: float,
    cos: float,
    sin: float,
    bounds: Floats,
    g: int,
    goals: GoalArrays,
) -> bool:
    """Whether a box around reachable places, turned by a heading, meets a goal's box."""
    if bounds[0] > bounds[1]:
        return False
    turned = (heading + bounds[4] - goals.heading[g, 0]) % (2.0 * np.pi)
    if turned > goals.heading[g, 1] and turned + bounds[5] - bounds[4] < 2.0 * np.pi:
        return False
    if goals.anywhere[g]:
        return True
    box = goals.boxes[g]
    gx, gy = 0.5 * (box[0] + box[1]) - x, 0.5 * (box[2] + box[3]) - y
    goal_x, goal_y = 0.5 * (box[1] - box[0]), 0.5 * (box[3] - box[2])
    bx, by = 0.5 * (bounds[0] + bounds[1]), 0.5 * (bounds[2] + bounds[3])
    half_x, half_y = 0.5 * (bounds[1] - bounds[0]), 0.5 * (bounds[3] - bounds[2])
    c, s = abs(cos), abs(sin)
    small = 1e-9
    # Separating axes: the node's two, then the world's two.
    if abs(cos * gx + sin * gy - bx) > half_x + c * goal_x + s * goal_y + small:
        return False
    if abs(cos * gy - sin * gx - by) > half_y + s * goal_x + c * goal_y + small:
        return False
    if abs(gx - (cos * bx - sin * by)) > goal_x + c * half_x + s * half_y + small:
        return False
    return abs(gy - (sin * bx + cos * by)) <= goal_y + s * half_x + c * half_y + small


@numba.njit(nogil=True, cache=True)
def _push(state: SearchState, key: float, node: int) -> None:
    keys, items = state.key, state.item
    hole = state.counters[1]
    state.counters[1] += 1
    while hole > 0:
        up = (hole - 1) // 2
        if keys[up] < key or (keys[up] == key and items[up] < node):
            break
        keys[hole], items[hole] = keys[up], items[up]
        hole = up
    keys[hole], items[hole] = key, node


@numba.njit(nogil=True, cache=True)
def _pop(state: SearchState) -> int:
    keys, items = state.key, state.item
    top = items[0]
    state.counters[1] -= 1
    size = state.counters[1]
    key, node = keys[size], items[size]
    hole = 0
    while True:
        child = 2 * hole + 1
        if child >= size:
            break
        other = child + 1
        if other < size and (
            keys[other] < keys[child]
            or (keys[other] == keys[child] and items[other] < items[child])
        ):
            child = other
        if key < keys[child] or (key == keys[child] and node < items[child]):
            break
        keys[hole], items[hole] = keys[child], items[child]
        hole = child
    keys[hole], items[hole] = key, node
    return top


@numba.njit(nogil=True, cache=True)
def _seen_before(node: int, primitives: PrimitiveArrays, state: SearchState) -> bool:
    """Look a node up in the closed list and enter it if its state is new."""
    if node == 0:
        return False
    mask = state.table.shape[0] - 1
    slot = _hash(node, primitives, state) & mask
    while state.table[slot] >= 0:
        if _same_state(node, state.table[slot], primitives, state):
            return True
        slot = (slot + 1) & mask
    state.table[slot] = node
    state.counters[4] += 1
    return False


@numba.njit(nogil=True, cache=True)
def _hash(node: int, primitives: PrimitiveArrays, state: SearchState) -> int:
    value = np.uint64(primitives.end_class[state.primitive[node]] * 4096 + state.step[node])
    for k in range(3):
        value ^= np.uint64(np.int64(np.rint(state.pose[node, k] / _QUANTUM)))
        value *= np.uint64(0x9E3779B97F4A7C15)
        value ^= value >> np.uint64(29)
    return np.int64(value >> np.uint64(1))


@numba.njit(nogil=True, cache=True)
def _same_state(one: int, two: int, primitives: PrimitiveArrays, state: SearchState) -> bool:
    if state.step[one] != state.step[two]:
        return False
    class_one = primitives.end_class[state.primitive[one]]
    if class_one != primitives.end_class[state.primitive[two]]:
        return False
    for k in range(3):
        if np.rint(state.pose[one, k] / _QUANTUM) != np.rint(state.pose[two, k] / _QUANTUM):
            return False
    return True


@numba.njit(nogil=True, cache=True)
def rehash(primitives: PrimitiveArrays, old: SearchState, new: SearchState) -> None:
    """Enter the closed nodes of one table into a larger, empty one."""
    mask = new.table.shape[0] - 1
    for i in range(old.table.shape[0]):
        node = old.table[i]
        if node >= 0:
            slot = _hash(node, primitives, new) & mask
            while new.table[slot] >= 0:
                slot = (slot + 1) & mask
            new.table[slot] = node


@numba.njit(nogil=True, cache=True)
def trajectory_to(
    node: int,
    primitives: PrimitiveArrays,
    limits: Limits,
    state: SearchState,
    steering_angle: float,
) -> Floats:
    """States from the start to a node as centre x, y, velocity, heading, steering angle.

    Args:
        node: Where the way ends.
        primitives: The set.
        limits: For the offset from the rear axle to the centre.
        state: The nodes.
        steering_angle: At the start.

    Returns:
        Shape (T, 5).
    """
    states = np.empty((state.step[node] - state.step[0] + 1, 5))
    child = node
    while state.parent[child] >= 0:
        parent = state.parent[child]
        x, y, heading = state.pose[parent, 0], state.pose[parent, 1], state.pose[parent, 2]
        cos, sin = np.cos(heading), np.sin(heading)
        before = state.step[parent] - state.step[0]
        for j in range(1, state.step[child] - state.step[parent] + 1):
            own = primitives.states[state.primitive[child], j]
            row = states[before + j]
            row[0], row[1] = cos * own[0] - sin * own[1] + x, sin * own[0] + cos * own[1] + y
            row[2], row[3], row[4] = own[2], heading + own[3], own[4]
        child = parent
    row = states[0]
    row[0], row[1], row[3] = state.pose[0, 0], state.pose[0, 1], state.pose[0, 2]
    row[2], row[4] = state.velocity[0], steering_angle
    for t in range(states.shape[0]):
        states[t, 0] += limits.centre_offset * np.cos(states[t, 3])
        states[t, 1] += limits.centre_offset * np.sin(states[t, 3])
    return states
