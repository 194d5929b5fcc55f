"""The search's memory: what is new is empty, what moves keeps its nodes."""

from __future__ import annotations

import numpy as np

from avsec_gym.planners.search_state import NODES, QUEUED, add_start, begin, grown, new_state


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
