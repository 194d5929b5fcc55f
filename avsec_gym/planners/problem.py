"""What a search is asked, laid out for the kernel."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel
from avsec_gym.planners.estimates import Limits
from avsec_gym.planners.goal import GoalArrays
from avsec_gym.planners.primitives import PrimitiveArrays


class Problem(NamedTuple):
    """Everything that a search needs to know but the obstacles."""

    root: NDArray[np.int64]
    """Primitives that may follow the start."""
    primitives: PrimitiveArrays
    branching: int
    """Most primitives that follow one."""
    goals: GoalArrays
    limits: Limits
    reach: Floats
    """Table of `avsec_gym.planners.reachability`; without rows, other bounds are used alone."""
    start: Floats
    """Rear-axle x, y, heading, shape (3,)."""
    speed: float
    """The speed that the primitives start with, m/s."""
    steering_angle: float
    """The steering angle that they start with, rad."""
    step: int
    """Time step of the start."""
    at_goal: bool
    """The start is a goal state already."""
    greedy: bool
    """GBFS instead of A*."""
    reference: bool
    """commonroad-search's search instead of the complete one."""


def plain(value: Any) -> Any:
    """The same with plain tuples in place of named ones, which numba reads in twice the time."""
    return tuple(plain(each) for each in value) if isinstance(value, tuple) else value


@kernel(nogil=True)
def named(parts: Any) -> Problem:
    """The problem that was made `plain`."""
    return Problem(
        parts[0],
        PrimitiveArrays(*parts[1]),
        parts[2],
        GoalArrays(*parts[3]),
        Limits(*parts[4]),
        parts[5],
        parts[6],
        parts[7],
        parts[8],
        parts[9],
        parts[10],
        parts[11],
        parts[12],
    )
