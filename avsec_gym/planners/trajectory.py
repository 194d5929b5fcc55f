"""The trajectory that leads to a node of the search."""

from __future__ import annotations

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel
from avsec_gym.planners.problem import Problem
from avsec_gym.planners.search_state import HEADING, PARENT, PRIMITIVE, STEP, SearchState, X, Y
from avsec_gym.planners.sweep import place_of


@kernel(nogil=True)
def trajectory_to(node: int, problem: Problem, state: SearchState) -> Floats:
    """States from the start to a node as centre x, y, velocity, heading, steering angle.

    Args:
        node: Number of the node at which the way ends.
        problem: The planning problem, whose primitives were driven.
        state: The nodes.

    Returns:
        Shape (T, 5).
    """
    own, centre_offset = problem.primitives.states, problem.limits.centre_offset
    pose, link = state.pose, state.link
    begun = link[0, STEP]
    states = np.empty((link[node, STEP] - begun + 1, 5))
    # From the end back to the start, primitive by primitive; rear axles.
    # Invariant: the rows behind `child`'s time step are filled.
    child = node
    while link[child, PARENT] >= 0:
        parent, p = link[child, PARENT], link[child, PRIMITIVE]
        x, y, heading, cos, sin = place_of(parent, pose, problem.reference)
        before = link[parent, STEP] - begun
        for j in range(1, link[child, STEP] - link[parent, STEP] + 1):
            t = before + j
            px, py = own[p, j, 0], own[p, j, 1]
            states[t, 0], states[t, 1] = cos * px - sin * py + x, sin * px + cos * py + y
            states[t, 2], states[t, 3] = own[p, j, 2], heading + own[p, j, 3]
            states[t, 4] = own[p, j, 4]
        child = parent
    states[0, 0], states[0, 1], states[0, 3] = pose[0, X], pose[0, Y], pose[0, HEADING]
    states[0, 2], states[0, 4] = problem.speed, problem.steering_angle
    # From rear axles to centres.
    for t in range(states.shape[0]):
        states[t, 0] += centre_offset * np.cos(states[t, 3])
        states[t, 1] += centre_offset * np.sin(states[t, 3])
    return states
