"""Batches of problems: the answers of the planner that takes them one by one, node for node."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.planners.batch import BatchPlans, RectangleTracks, plan_batch
from avsec_gym.planners.plan import Plan
from avsec_gym.planners.planner import Algorithm, MotionPrimitivePlanner
from avsec_gym.planners.primitives import generate_primitives
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.planning_scenario import EgoState, Goal, PlanningScenario
from avsec_gym.scenario.road import Road, straight_lanes
from avsec_gym.scenario.shapes import Rectangle

_LAST, _ROWS = 30, 4
_FAR = 1e7


def _scenario() -> PlanningScenario:
    goal = Goal((4, _LAST), (Rectangle(5.0, 3.5, 15.0, 1.0),), (-0.5, 0.5))
    start = EgoState(velocity=6.0)
    return PlanningScenario("batch", start, (goal,), road=Road(straight_lanes(3)))


def _obstacles(seed: int) -> Obstacles:
    """Up to four rectangles in the way, some of them moving."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(0, _ROWS + 1))
    poses = np.column_stack(
        [rng.uniform(3, 25, count), rng.uniform(-3, 7, count), rng.uniform(-0.5, 0.5, count)]
    )
    speeds = rng.choice([0.0, 4.0], count)
    sizes = rng.uniform(0.5, 3, count), rng.uniform(0.5, 2, count)
    return Obstacles.rectangles(poses, *sizes, speeds, last_step=_LAST)


def _tracks(sets: list[Obstacles]) -> RectangleTracks:
    """The same as a batch; rows that are left over are far away."""
    half_sizes = np.zeros((len(sets), _ROWS, 2))
    poses = np.full((len(sets), _ROWS, _LAST + 1, 4), _FAR)
    for b, each in enumerate(sets):
        for i, (shape, track) in enumerate(zip(each.shapes, each.poses, strict=True)):
            assert isinstance(shape, Rectangle)
            half_sizes[b, i] = shape.length / 2, shape.width / 2
            steps = np.minimum(np.arange(_LAST + 1), len(track) - 1)
            x, y, heading = track[steps].T
            poses[b, i] = np.column_stack([x, y, np.cos(heading), np.sin(heading)])
    return RectangleTracks(half_sizes, poses)


@pytest.mark.parametrize("algorithm", list(Algorithm))
@pytest.mark.parametrize("node_limit", [10, 4000])
def test_each_answer_is_that_of_the_single_planner(algorithm: Algorithm, node_limit: int) -> None:
    primitives = generate_primitives((4.0, 6.0, 8.0), steering_angles=7)
    planner = MotionPrimitivePlanner(algorithm, primitives=primitives, node_limit=node_limit)
    scenario = _scenario()
    sets = [_obstacles(seed) for seed in range(24)]
    plans = plan_batch(
        planner.problem(scenario, primitives),
        _LAST + 1,
        scenario.road.closed_edges,
        _tracks(sets),
        node_limit,
    )
    single = [planner.plan(scenario.with_obstacles(each), explain=False) for each in sets]
    assert {plan.trajectory is not None for plan in single} == {True, False}
    for b, plan in enumerate(single):
        _same(plans, b, plan)


def _same(plans: BatchPlans, b: int, plan: Plan) -> None:
    assert plans.expanded[b] == plan.expanded
    assert bool(plans.found[b]) == (plan.trajectory is not None)
    if plan.trajectory is None:
        assert plans.lengths[b] == 0
        assert np.isnan(plans.cost[b])
        return
    length = len(plan.trajectory)
    assert plans.lengths[b] == length
    assert plans.cost[b] == plan.cost
    np.testing.assert_array_equal(plans.trajectories[b, :length], plan.trajectory)
    # What is left over repeats the last state.
    rest = plans.trajectories[b, length:]
    np.testing.assert_array_equal(rest, np.broadcast_to(plan.trajectory[-1], rest.shape))
