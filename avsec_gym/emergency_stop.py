"""An emergency stop: what a car does that no longer trusts its sensors.

It is judged as any trajectory is, until the car stands, and may touch something.  But it reaches no
goal: a stop that touches nothing is no safe plan, it is filed as ``unplanned`` for the reason
`STOPPED`, so that a car that always stops drives nowhere safely.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from avsec_gym.metrics.safety import UNPLANNED, SafetyRecord, judge
from avsec_gym.planners.plan import Plan, Status
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.planning_scenario import PlanningScenario

STOPPED = "stopped"
"""Why nothing was planned: the `reason` of every stop, of one that collides, too."""
DECELERATION = 8.0
"""m/s2: full braking on a dry road; the vehicle's friction circle would allow 11.5."""


def emergency_stop(problem: PlanningScenario, deceleration: float = DECELERATION) -> Plan:
    """Full braking along the lane that the car is in, until it stands; nothing is looked at.

    Args:
        problem: The problem, whose start and time step matter.
        deceleration: The deceleration, m/s2.

    Example:
        >>> from avsec_gym.scenario.planning_scenario import EgoState
        >>> plan = emergency_stop(PlanningScenario("1", EgoState(velocity=6.0), ()))
        >>> plan.cost, float(plan.trajectory[-1, 0])
        (0.75, 2.25)
    """
    start = problem.start
    duration = start.velocity / deceleration
    steps = math.ceil(duration / problem.dt - 1e-9)
    time = np.minimum(problem.dt * np.arange(steps + 1), duration)
    driven = start.velocity * time - deceleration * time**2 / 2
    trajectory = np.zeros((len(time), 5))
    trajectory[:, 0] = start.x + driven * math.cos(start.heading)
    trajectory[:, 1] = start.y + driven * math.sin(start.heading)
    trajectory[:, 2] = start.velocity - deceleration * time
    trajectory[:, 3] = start.heading
    return Plan(Status.FOUND, trajectory, start.step, start.velocity, cost=duration)


def judge_stop(plan: Plan, problem: PlanningScenario, truth: Obstacles) -> SafetyRecord:
    """Hold a stop against what is really there.

    Args:
        plan: The plan of `emergency_stop`.
        problem: The problem that the planner was asked to solve.
        truth: The real obstacles.
    """
    record = replace(judge(plan, problem, truth), reason=STOPPED)
    if record.collision:
        return record
    nan = math.nan
    return replace(
        record,
        outcome=UNPLANNED,
        cost=nan,
        path_length=nan,
        travel_time=nan,
        sm1_cost=nan,
        swept_collision=None,
    )
