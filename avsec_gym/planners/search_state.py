"""The search's memory: nodes, a binary heap as queue, and a hash table as closed list."""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats
from avsec_gym.planners.primitives import PrimitiveArrays

_QUANTUM = 1e-6
"""States that agree to this (m, rad) are one state to the closed list."""


class SearchState(NamedTuple):
    """Nodes, queue and closed list; `grown` makes room for more."""

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
def new_state(nodes: int, table: int) -> SearchState:
    """Empty memory.

    Args:
        nodes: Room for so many.
        table: Slots of the closed list, a power of two.
    """
    return SearchState(
        np.empty((nodes, 3)),
        np.empty(nodes),
        np.empty(nodes),
        np.empty(nodes, np.int64),
        np.empty(nodes, np.int64),
        np.empty(nodes, np.int64),
        np.empty(nodes, np.int64),
        np.empty(nodes),
        np.empty(nodes, np.int64),
        np.full(table, -1),
        np.zeros(5, np.int64),
    )


@numba.njit(nogil=True, cache=True)
def begin(state: SearchState, start: Floats, speed: float, step: int, at_goal: bool) -> None:
    """Forget everything; the start is the only node, and in the queue.

    Args:
        state: The memory.
        start: Rear-axle x, y, heading.
        speed: m/s.
        step: Time step of the start.
        at_goal: The start is a goal state already.
    """
    state.pose[0] = start
    state.elapsed[0], state.velocity[0] = 0.0, speed
    state.parent[0], state.primitive[0], state.step[0] = -1, -1, step
    state.goal_index[0] = 0 if at_goal else -1
    state.key[0], state.item[0] = 0.0, 0
    state.table[:] = -1
    state.counters[0], state.counters[1], state.counters[2] = 1, 1, 0
    state.counters[3], state.counters[4] = -1, 0


@numba.njit(nogil=True, cache=True)
def grown(state: SearchState, primitives: PrimitiveArrays) -> SearchState:
    """The same memory with twice the room."""
    used, queued = state.counters[0], state.counters[1]
    new = new_state(2 * state.parent.shape[0], 2 * state.table.shape[0])
    new.pose[:used] = state.pose[:used]
    new.elapsed[:used], new.velocity[:used] = state.elapsed[:used], state.velocity[:used]
    new.parent[:used], new.primitive[:used] = state.parent[:used], state.primitive[:used]
    new.step[:used], new.goal_index[:used] = state.step[:used], state.goal_index[:used]
    new.key[:queued], new.item[:queued] = state.key[:queued], state.item[:queued]
    new.counters[:] = state.counters
    mask = new.table.shape[0] - 1
    for i in range(state.table.shape[0]):
        node = state.table[i]
        if node >= 0:
            slot = _hash(node, primitives, new) & mask
            while new.table[slot] >= 0:
                slot = (slot + 1) & mask
            new.table[slot] = node
    return new


@numba.njit(nogil=True, cache=True)
def push(state: SearchState, key: float, node: int) -> None:
    """Queue a node."""
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
def pop(state: SearchState) -> int:
    """Take the node with the lowest key; among equals, the oldest."""
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
def seen_before(node: int, primitives: PrimitiveArrays, state: SearchState) -> bool:
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
    return int(value >> np.uint64(1))


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
def turn(heading: float, reference: bool) -> tuple[float, float]:
    """Cosine and sine by which a primitive is turned into its place.

    Up to 0.05 rad commonroad-io takes 1 and the angle, and so reference mode does.
    """
    if reference:
        heading = np.fmod(heading, 2.0 * np.pi)
        if abs(heading) <= 0.05:
            return 1.0, heading
    return np.cos(heading), np.sin(heading)
