"""What a search is asked, laid out for the kernel."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import PlanningError
from avsec_gym.geometry import Floats
from avsec_gym.planners.estimates import HeuristicLimits, heuristic_limits
from avsec_gym.planners.goal import GoalArrays, goal_arrays, reaches
from avsec_gym.planners.handles import handle_of
from avsec_gym.planners.primitives import MotionPrimitives, PrimitiveArrays
from avsec_gym.planners.reachability import reach_table
from avsec_gym.scenario.planning_scenario import EgoState, Goal

_NO_TABLE = np.zeros((0, 1, 6))
_ROLLING_BACK = 0.1
"""m/s: so fast do vehicles move backwards that stand and are recorded."""
_FASTER = 10.0
"""m/s above the fastest start of the primitives: nothing faster is planned with them."""


class Problem(NamedTuple):
    """Everything that a search needs to know but the obstacles."""

    root: NDArray[np.int64]
    """Primitives that may follow the start."""
    primitives: PrimitiveArrays
    branching: int
    """Most primitives that follow one."""
    goals: GoalArrays
    limits: HeuristicLimits
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


@lru_cache(maxsize=256)
def problem_of(
    primitives: MotionPrimitives,
    start: EgoState,
    goals: tuple[Goal, ...],
    *,
    greedy: bool,
    reference: bool,
) -> tuple[Problem, Any]:
    """The problem of a start and goals, and the handle on it with which the search is called.

    Args:
        primitives: The primitives that are strung together.
        start: The state of the ego vehicle.
        goals: The goals, one of which is to be reached.
        greedy: Whether GBFS searches instead of A*.
        reference: Whether the search is commonroad-search's instead of the complete one.

    Raises:
        PlanningError: There is no goal, no primitive starts at the start speed, or that is negative
            or far above all that primitives start at.
    """
    # commonroad-search starts with straight wheels whatever the file states.
    steering = 0.0 if reference else start.steering_angle
    _check_start_speed(start.velocity, primitives)
    speed = primitives.nearest_speed(start.velocity, endless_only=reference)
    root = primitives.starting_at(speed, steering, endless_only=reference)
    if not len(root):
        raise PlanningError(
            f"no primitive of {primitives.name} starts at {speed:g} m/s with a steering angle of"
            f" {steering:g} rad"
        )
    laid_out = goal_arrays(goals)
    horizon = max(0, max(goal.steps[1] for goal in goals) - start.step)
    offset = primitives.vehicle.rear_axle
    x, y = start.x - offset * math.cos(start.heading), start.y - offset * math.sin(start.heading)
    problem = Problem(
        root=root,
        primitives=primitives.arrays,
        branching=max(len(root), int(np.diff(primitives.arrays.first_successor).max())),
        goals=laid_out,
        limits=heuristic_limits(primitives),
        reach=_NO_TABLE if reference else reach_table(primitives, horizon),
        start=np.array([x, y, start.heading]),
        speed=speed,
        steering_angle=steering,
        step=start.step,
        at_goal=bool(reaches(start.x, start.y, start.heading, speed, start.step, laid_out)),
        greedy=greedy,
        reference=reference,
    )
    return problem, handle_of(problem)


def _check_start_speed(velocity: float, primitives: MotionPrimitives) -> None:
    """Refuse a start that drives backwards, or far faster than the primitives.

    Slower ones than the slowest primitive are planned: the thesis' scenarios state 0 m/s.
    """
    fastest = float(primitives.states[:, 0, 2].max())
    if not -_ROLLING_BACK <= velocity <= fastest + _FASTER:
        raise PlanningError(
            f"the start's velocity is {velocity:g} m/s; expected 0 to {fastest + _FASTER:g} m/s,"
            f" {_FASTER:g} m/s above the fastest start of the primitives {primitives.name}."
            " Correct the velocity, or name other primitives"
        )
