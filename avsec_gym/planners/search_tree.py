"""The tree of a search, for pictures."""

from __future__ import annotations

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.planners.search_state import (
    COS,
    GOAL,
    NODES,
    PARENT,
    REFUSED,
    SIN,
    SearchState,
    X,
    Y,
)


def search_tree(state: SearchState, centre_offset: float) -> Floats:
    """The nodes whose ways are free, as centres x, y and numbers of their parents.

    Args:
        state: The nodes of a search.
        centre_offset: Metres from the rear axle, which nodes stand for, to the vehicle's centre.

    Returns:
        Shape (N, 3); the start's parent is -1.
    """
    used = int(state.counters[NODES])
    pose, link = state.pose[:used], state.link[:used]
    free = link[:, GOAL] != REFUSED
    number = np.append(np.cumsum(free) - 1, -1)
    return np.column_stack(
        [
            pose[:, X] + centre_offset * pose[:, COS],
            pose[:, Y] + centre_offset * pose[:, SIN],
            number[link[:, PARENT]],
        ]
    )[free]
