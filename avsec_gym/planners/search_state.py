"""The search's memory: nodes, a binary heap as queue, and a hash table as closed list."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel

X, Y, HEADING, COS, SIN, ELAPSED = range(6)
"""Columns of `SearchState.pose`."""
PARENT, PRIMITIVE, STEP, GOAL = range(4)
"""Columns of `SearchState.link`."""
NODES, QUEUED, EXPANDED, GOAL_NODE, CLOSED = range(5)
"""Places in `SearchState.counters`."""
NO_GOAL, REFUSED = -1, -2
"""Values in the column `GOAL`, in this order: the way to a node holds no goal state; it touches
something."""

_QUANTUM = 1e-6
"""States that agree to this (m, rad) are one state to the closed list."""


class SearchState(NamedTuple):
    """Nodes, queue and closed list; `grown` makes room for more."""

    pose: Floats
    """Rear axle x, y, heading, its cosine and sine, priority g in seconds, shape (N, 6)."""
    link: NDArray[np.int32]
    """Parent, primitive that leads here, time step, and which state of that primitive is the first
    in a goal (`NO_GOAL`, `REFUSED`), shape (N, 4)."""
    key: Floats
    """Binary heap: priorities, shape (N,)."""
    item: NDArray[np.int64]
    """Binary heap: nodes, shape (N,); a node's number is its insertion number."""
    table: NDArray[np.int64]
    """Closed list: open-addressing hash table of nodes, -1 where free; a power of two long."""
    counters: NDArray[np.int64]
    """Nodes, heap size, expanded, goal node, entries in the closed list."""


@register_jitable
def new_state(nodes: int, table: int) -> SearchState:
    """Empty memory.

    Args:
        nodes: Room for so many.
        table: Slots of the closed list, a power of two.
    """
    return SearchState(
        np.empty((nodes, 6)),
        np.empty((nodes, 4), np.int32),
        np.empty(nodes),
        np.empty(nodes, np.int64),
        np.full(table, -1),
        np.zeros(5, np.int64),
    )


@kernel(nogil=True)
def begin(state: SearchState) -> None:
    """Forget everything."""
    state.table[:] = -1
    state.counters[:] = 0


@kernel(nogil=True)
def add_start(state: SearchState, start: Floats, step: int, at_goal: bool) -> None:
    """The first node, which no primitive leads to.

    Args:
        state: Empty memory.
        start: Rear-axle x, y, heading.
        step: Time step of the start.
        at_goal: The start is a goal state already.
    """
    pose, link, counters = state.pose, state.link, state.counters
    pose[0, X], pose[0, Y], pose[0, HEADING] = start[0], start[1], start[2]
    pose[0, COS], pose[0, SIN], pose[0, ELAPSED] = np.cos(start[2]), np.sin(start[2]), 0.0
    link[0, PARENT], link[0, PRIMITIVE], link[0, STEP] = -1, -1, step
    link[0, GOAL] = 0 if at_goal else NO_GOAL
    state.key[0], state.item[0] = 0.0, 0
    counters[NODES], counters[QUEUED] = 1, 1


@kernel(nogil=True)
def grown(state: SearchState, end_class: NDArray[np.int64]) -> SearchState:
    """The same memory with twice the room; closed nodes get new slots, all else keeps its place."""
    new = new_state(2 * state.key.shape[0], 2 * state.table.shape[0])
    move(state, new, end_class)
    return new


@kernel(nogil=True)
def move(state: SearchState, new: SearchState, end_class: NDArray[np.int64]) -> None:
    """Move everything into memory with more room, whatever was in that.

    Element by element: assignments of slices are compiled three times as long.
    """
    # Nodes, queue and counters keep their places.
    for i in range(state.counters[NODES]):
        for k in range(state.pose.shape[1]):
            new.pose[i, k] = state.pose[i, k]
        for k in range(state.link.shape[1]):
            new.link[i, k] = state.link[i, k]
    for i in range(state.counters[QUEUED]):
        new.key[i], new.item[i] = state.key[i], state.item[i]
    for i in range(state.counters.shape[0]):
        new.counters[i] = state.counters[i]
    # Invariant: the new table holds the old one's nodes so far, each in the first free slot.
    new.table[:] = -1
    mask = new.table.shape[0] - 1
    for i in range(state.table.shape[0]):
        node = state.table[i]
        if node >= 0:
            slot = _hash(node, end_class, new.pose, new.link) & mask
            while new.table[slot] >= 0:
                slot = (slot + 1) & mask
            new.table[slot] = node


@kernel(nogil=True)
def push(key: float, node: int, keys: Floats, items: NDArray[np.int64], size: int) -> None:
    """Put a node into a heap of a size.

    Invariant of the heap: no entry comes before its parent, by key and then by number.
    """
    hole = size
    while hole > 0:
        up = (hole - 1) >> 1
        if keys[up] < key or (keys[up] == key and items[up] < node):
            break
        keys[hole], items[hole] = keys[up], items[up]
        hole = up
    keys[hole], items[hole] = key, node


@kernel(nogil=True)
def pop(keys: Floats, items: NDArray[np.int64], size: int) -> int:
    """Take the node with the lowest key from a heap of a size; among equals, the oldest.

    The last entry sinks from the root to its place; the heap has one entry less.
    """
    top = items[0]
    size -= 1
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
    return int(top)


@kernel(nogil=True)
def closed_slot(
    node: int,
    end_class: NDArray[np.int64],
    pose: Floats,
    link: NDArray[np.int32],
    table: NDArray[np.int64],
) -> int:
    """The free slot of the closed list for a node; -1 where its state was met before.

    Invariant: the table is at most half full, so that a search of slots ends at a free one.
    """
    mask = table.shape[0] - 1
    slot = _hash(node, end_class, pose, link) & mask
    while table[slot] >= 0:
        if _same_state(node, table[slot], end_class, pose, link):
            return -1
        slot = (slot + 1) & mask
    return slot


@kernel(nogil=True)
def _hash(node: int, end_class: NDArray[np.int64], pose: Floats, link: NDArray[np.int32]) -> int:
    """A number that is equal for equal states (`_same_state`), well mixed, never negative."""
    value = np.uint64(end_class[link[node, PRIMITIVE]] * 4096 + link[node, STEP])
    for k in range(3):
        value ^= np.uint64(np.int64(np.rint(pose[node, k] / _QUANTUM)))
        value *= np.uint64(0x9E3779B97F4A7C15)
        value ^= value >> np.uint64(29)
    return int(value >> np.uint64(1))


@kernel(nogil=True)
def _same_state(
    one: int, two: int, end_class: NDArray[np.int64], pose: Floats, link: NDArray[np.int32]
) -> bool:
    """Whether two nodes agree in time step, class of the last primitive and rounded pose."""
    if link[one, STEP] != link[two, STEP]:
        return False
    if end_class[link[one, PRIMITIVE]] != end_class[link[two, PRIMITIVE]]:
        return False
    for k in range(3):
        if np.rint(pose[one, k] / _QUANTUM) != np.rint(pose[two, k] / _QUANTUM):
            return False
    return True
