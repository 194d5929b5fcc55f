"""Lower bounds of the time to a goal: they may be too low, never too high."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.planners import problem
from avsec_gym.planners.plan import Status
from avsec_gym.planners.planner import MotionPrimitivePlanner
from avsec_gym.planners.primitives import generate_primitives
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.planning_scenario import EgoState, Goal, PlanningScenario
from avsec_gym.scenario.road import Road

# Where kernels are plain Python, numpy warns of hashes that overflow, as they shall.
pytestmark = pytest.mark.filterwarnings("ignore:overflow encountered:RuntimeWarning")
_NARROW = 1e-4


def test_a_goal_that_begins_or_ends_at_a_reachable_heading_is_not_shut_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    primitives = generate_primitives((6.0, 8.0))
    arrays, rng = primitives.arrays, np.random.default_rng(0)
    roots = primitives.starting_at(6.0, 0.0)
    borders = []
    for _ in range(250):
        start = float(rng.uniform(-3, 3))
        way = [rng.choice(roots)]
        for _ in range(2):
            first, last = arrays.first_successor[way[-1] : way[-1] + 2]
            way.append(rng.choice(arrays.successors[first:last]))
        heading = start
        for primitive in way:
            heading += arrays.states[primitive, arrays.steps[primitive], 3]
        borders += [(start, heading, heading + _NARROW), (start, heading - _NARROW, heading)]

    def statuses() -> list[Status]:
        problem.problem_of.cache_clear()
        planner = MotionPrimitivePlanner(primitives=primitives)
        return [planner.plan(_turning(*border), explain=False).status for border in borders]

    with_table = statuses()
    # Without a table only distances and windows bound the time: headings shut nothing out.
    monkeypatch.setattr(problem, "reach_table", lambda _, last: np.zeros((0, last + 1, 6)))
    assert with_table == statuses()
    assert with_table.count(Status.FOUND) > 400
    problem.problem_of.cache_clear()


def _turning(start: float, low: float, high: float) -> PlanningScenario:
    """A goal at any place, at time step 15, with headings of an interval."""
    goal = Goal((15, 15), None, (low, high))
    state = EgoState(0.0, 0.0, 6.0, start, 0.0, 0)
    return PlanningScenario("turn", state, (goal,), road=Road(()), obstacles=Obstacles.none())
