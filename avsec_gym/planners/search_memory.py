"""The memory that a thread's searches use one after another: new memory costs most of the time."""

from __future__ import annotations

import threading
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.machine_memory import half_of_memory
from avsec_gym.planners.handles import handle_of
from avsec_gym.planners.search_state import SearchState, move, new_state

ROOM = 2048
"""Nodes to make room for at first."""
_MOST_KEPT = 2**19
"""Nodes up to which a thread keeps memory for later searches: at most 92 MB for all sizes, and 84
MB for those of reference mode."""
_of_this_thread = threading.local()


class SearchMemory(NamedTuple):
    """Memory, and the handle that the kernel is called with."""

    state: SearchState
    handle: Any


def first_memory(reference: bool) -> SearchMemory:
    """Where this thread's searches begin, with whatever the last one left.

    Args:
        reference: Whether the search has no closed list.
    """
    kept: dict[bool, SearchMemory] = vars(_of_this_thread).setdefault("first", {})
    memory = kept.get(reference)
    if memory is None:
        memory = kept[reference] = _memory_of(new_state(ROOM, 2 if reference else ROOM))
    return memory


def more_memory(state: SearchState, end_class: NDArray[np.int64]) -> SearchMemory:
    """The same nodes, queue and closed list in memory with twice the room (see `grown`).

    Each size is kept apart, so that small searches have small memory to empty.

    Raises:
        MemoryError: There is none; what was there is as it was.
    """
    nodes, slots = 2 * len(state.key), 2 * len(state.table)
    if nodes > _MOST_KEPT:
        if 2 * sum(array.nbytes for array in state) > half_of_memory():
            raise MemoryError
        # Not in the kernel, which would keep a part of it where the rest cannot be had.
        more = new_state(nodes, slots)
        move(state, more, end_class)
        return _memory_of(more)
    kept: dict[tuple[int, int], SearchMemory] = vars(_of_this_thread).setdefault("larger", {})
    if (nodes, slots) not in kept:
        kept[nodes, slots] = _memory_of(new_state(nodes, slots))
    move(state, kept[nodes, slots].state, end_class)
    return kept[nodes, slots]


def _memory_of(state: SearchState) -> SearchMemory:
    return SearchMemory(state, handle_of(state))
