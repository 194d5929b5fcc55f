"""The search's memory: what is new is empty, what moves keeps its nodes."""

from __future__ import annotations

import heapq

import numpy as np
import pytest

from avsec_gym.planners.search_state import (
    NO_GOAL,
    NODES,
    QUEUED,
    SearchState,
    _hash,
    _same_state,
    add_start,
    begin,
    closed_slot,
    grown,
    new_state,
    pop,
    push,
)

# Where kernels are plain Python, numpy warns of hashes that overflow, as they shall.
pytestmark = pytest.mark.filterwarnings("ignore:overflow encountered:RuntimeWarning")


def test_new_memory_holds_nothing():
    state = new_state(4, 8)
    assert [len(state.pose), len(state.link), len(state.key), len(state.item)] == [4] * 4
    # Else the first look into the closed list goes to nodes that are not there.
    assert state.table.tolist() == [-1] * 8
    assert not state.counters.any()


def test_memory_that_was_used_holds_nothing_after_it_begins_anew():
    state = new_state(4, 8)
    add_start(state, np.array([1.0, 2.0, 0.3]), 5, False)
    state.table[3] = 0
    begin(state)
    assert (state.table == -1).all()
    assert not state.counters.any()


def test_memory_that_grows_keeps_its_nodes_and_closes_the_same_ones():
    state = new_state(4, 8)
    add_start(state, np.array([1.0, 2.0, 0.3]), 5, False)
    state.table[3] = 0
    more = grown(state, np.zeros(1, np.int64))
    assert [len(more.pose), len(more.key), len(more.table)] == [8, 8, 16]
    assert [int(more.counters[NODES]), int(more.counters[QUEUED])] == [1, 1]
    np.testing.assert_array_equal(more.pose[0], state.pose[0])
    np.testing.assert_array_equal(more.link[0], state.link[0])
    assert sorted(more.table.tolist()) == [-1] * 15 + [0]


@pytest.mark.parametrize(("at_goal", "goal"), [(True, 0), (False, NO_GOAL)])
def test_the_start_is_the_first_node_and_the_only_one_in_the_queue(at_goal: bool, goal: int):
    state = new_state(3, 8)
    state.pose[:], state.link[:], state.key[:], state.item[:] = 7.0, 7, 7.0, 7
    begin(state)
    add_start(state, np.array([1.0, 2.0, 0.3]), 5, at_goal)
    assert state.pose[0].tolist() == pytest.approx([1.0, 2.0, 0.3, np.cos(0.3), np.sin(0.3), 0.0])
    assert state.link[0].tolist() == [-1, -1, 5, goal]
    assert (state.key[0], state.item[0]) == (0.0, 0)
    assert state.counters.tolist() == [1, 1, 0, 0, 0]
    assert (state.pose[1:] == 7.0).all()


@pytest.mark.parametrize("keys", [2, 5, 1000])
def test_the_queue_gives_the_lowest_key_and_of_equal_ones_the_oldest(keys: int):
    random = np.random.default_rng(keys)
    key, item, size, heap = np.empty(200), np.empty(200, np.int64), 0, []
    for node in random.permutation(150):
        value = float(random.integers(keys))
        push(value, node, key, item, size)
        heapq.heappush(heap, (value, int(node)))
        size += 1
        while size and random.random() < 0.4:
            assert pop(key, item, size) == heapq.heappop(heap)[1]
            size -= 1
            assert sorted(zip(key[:size], item[:size], strict=True)) == sorted(heap)
            # No entry comes before its parent.
            entries = list(zip(key[:size], item[:size], strict=True))
            assert all(entries[(k - 1) // 2] < entries[k] for k in range(1, size))
    while size:
        assert pop(key, item, size) == heapq.heappop(heap)[1]
        size -= 1


_CLASSES = np.array([0, 1, 1, 2, 9])
"""Of five primitives, of which the second and the third are followed by the same ones, and the
last one stands for none."""


def _nodes(count: int, seed: int, room: int = 0, table: int = 256) -> SearchState:
    """Nodes of few states, many of them twice; poses are a little off a grid of the quantum."""
    random = np.random.default_rng(seed)
    state = new_state(room or count, table)
    grid = np.add(random.integers(-2, 2, (count, 3)), [10**6, -3 * 10**7, 0])
    state.pose[:count] = random.normal(size=(count, 6))
    state.pose[:count, :3] = 1e-6 * (grid + random.uniform(-0.4, 0.4, (count, 3)))
    state.link[:count] = np.column_stack(
        [
            random.integers(-1, 9, count),
            random.integers(-1, 4, count),
            random.integers(7, 9, count),
            random.integers(-2, 3, count),
        ]
    )
    state.key[:count], state.item[:count] = random.random(count), random.permutation(count)
    state.counters[:] = count, count - 1, 5, 6, 0
    return state


def _identity(state: SearchState, node: int) -> tuple[int, ...]:
    """What makes two states one: time step, class of the last primitive, rounded pose."""
    grid = (round(1e6 * value) for value in state.pose[node, :3].tolist())
    _, primitive, step, _ = state.link[node].tolist()
    return step, int(_CLASSES[primitive]), *grid


def _closed(state: SearchState, node: int) -> int:
    """Close a node if its state is new; the slot, or -1."""
    slot = closed_slot(node, _CLASSES, state.pose, state.link, state.table)
    if slot >= 0:
        assert state.table[slot] == -1
        state.table[slot] = node
    return int(slot)


@pytest.mark.parametrize("seed", range(4))
def test_a_state_is_closed_once(seed: int):
    state, met = _nodes(160, seed), set()
    for node in range(160):
        identity = _identity(state, node)
        assert (_closed(state, node) == -1) == (identity in met)
        met.add(identity)
    assert 20 < len(met) < 150
    pairs = np.random.default_rng(seed).integers(0, 160, (300, 2))
    for one, two in pairs:
        expected = _identity(state, one) == _identity(state, two)
        assert _same_state(one, two, _CLASSES, state.pose, state.link) == expected
        if expected:
            hashes = {_hash(node, _CLASSES, state.pose, state.link) for node in (one, two)}
            assert len(hashes) == 1


@pytest.mark.parametrize(
    ("column", "value", "same"),
    [
        ("x", 1.0000003, True), ("x", 1.0000007, False), ("x", 0.9999993, False),
        ("y", 2.0000007, False), ("heading", 0.5000007, False), ("heading", 0.4999997, True),
        # What is after the heading, the parent and the goal make no other state.
        ("cos", 7.0, True), ("sin", 7.0, True), ("parent", 3, True), ("goal", 2, True),
        ("step", 9, False), ("primitive", 1, True), ("primitive", 3, False),
        ("primitive", -1, False),
    ],
)  # fmt: skip
def test_two_nodes_are_one_state(column: str, value: float, same: bool):
    pose, link = np.tile([1.0, 2.0, 0.5, 0.9, 0.5, 3.0], (2, 1)), np.tile([1, 2, 8, -1], (2, 1))
    link = link.astype(np.int32)
    if column in ("parent", "primitive", "step", "goal"):
        link[1, ("parent", "primitive", "step", "goal").index(column)] = value
    else:
        pose[1, ("x", "y", "heading", "cos", "sin").index(column)] = value
    assert _same_state(0, 1, _CLASSES, pose, link) == same
    assert (_hash(0, _CLASSES, pose, link) == _hash(1, _CLASSES, pose, link)) == same


def test_hashes_fall_into_all_slots():
    """Neighbours on a grid, as searches make them, one unlike the next in one number alone."""
    pose, link = np.zeros((240, 6)), np.zeros((240, 4), np.int32)
    pose[:60, 0], pose[60:120, 1], pose[120:180, 2] = (1e-6 * np.arange(1, 61),) * 3
    link[180:, 2] = np.arange(100, 160)
    hashes = np.array([_hash(node, _CLASSES, pose, link) for node in range(240)])
    assert (hashes >= 0).all()
    assert len(np.unique(hashes)) == 240
    assert len(np.unique(hashes % 64)) > 57
    assert np.bincount(hashes % 64).max() < 16


@pytest.mark.parametrize("seed", range(8))
def test_memory_that_grows_finds_every_closed_state_again(seed: int):
    # Half of the slots are taken, so that many nodes want the same one.
    count = 16
    state = _nodes(count, 20 + seed, room=20, table=32)
    # No two are one state.
    state.pose[:count, 0] += np.arange(count)
    closed = [node for node in range(count) if _closed(state, node) >= 0]
    assert len(closed) == count
    more = grown(state, _CLASSES)
    assert [len(more.pose), len(more.link), len(more.key), len(more.item)] == [40] * 4
    assert len(more.table) == 64
    np.testing.assert_array_equal(more.pose[:count], state.pose[:count])
    np.testing.assert_array_equal(more.link[:count], state.link[:count])
    # One node has left the queue.
    np.testing.assert_array_equal(more.key[: count - 1], state.key[: count - 1])
    np.testing.assert_array_equal(more.item[: count - 1], state.item[: count - 1])
    np.testing.assert_array_equal(more.counters, state.counters)
    assert sorted(more.table[more.table >= 0].tolist()) == closed
    for node in closed:
        assert closed_slot(node, _CLASSES, more.pose, more.link, more.table) == -1
    # From the slot of its hash on to its own, none is free: else a search would end there.
    for slot in np.flatnonzero(more.table >= 0):
        at = _hash(more.table[slot], _CLASSES, more.pose, more.link) % 64
        while at != slot:
            assert more.table[at] >= 0
            at = (at + 1) % 64
