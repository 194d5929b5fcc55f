"""All chains of primitives: drivable, every one there, and judged like the planner judges them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.metrics.collision_check import first_contact
from avsec_gym.planners.planner import MotionPrimitivePlanner
from avsec_gym.planners.primitives import suitable_primitives
from avsec_gym.planners.vehicle import BMW_320I
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.intention import Intention
from studies.chapter5.measures.trajectory_bundle import trajectory_bundle
from tests.metrics.test_contact_recall import scenario

CAR = ([14.0, 0.5, 0.3], 4.0, 1.8, 0.0)
AHEAD = ([16.0, 3.0, 0.0], 4.2, 1.7, 7.0)
BEHIND = ([-9.0, 0.0, 0.0], 4.2, 1.7, 0.0)


@pytest.mark.parametrize("road_type", RoadType)
def test_chains_are_drivable_and_every_one_is_there(road_type: RoadType) -> None:
    problem = scenario(road_type=road_type)
    states = trajectory_bundle(problem).states
    primitives = suitable_primitives(problem)
    # By counting walks through the graph of what may follow what.
    walks = np.zeros(len(primitives))
    walks[primitives.starting_at(problem.start.velocity)] = 1
    for _ in range(3):
        walks = walks @ primitives.follows
    assert len(states) == walks.sum() == len(np.unique(states.reshape(len(states), -1), axis=0))
    assert states.shape[1:] == (21, 5)
    # Every chain begins at the start, and moves as far as its speed says.
    np.testing.assert_allclose(states[:, 0, :2], 0, atol=1e-12)
    moved = np.linalg.norm(np.diff(states[..., :2], axis=1), axis=2)
    speed = 0.5 * (states[:, 1:, 2] + states[:, :-1, 2])
    np.testing.assert_allclose(moved, 0.1 * speed, rtol=0.12)


def test_a_start_elsewhere_moves_and_turns_all_chains_with_it() -> None:
    problem = scenario()
    there = replace(problem.start, x=3.0, y=-2.0, heading=0.9)
    at_origin = trajectory_bundle(problem).states
    moved = trajectory_bundle(replace(problem, start=there)).states
    turned = at_origin[..., :2] @ [[np.cos(0.9), np.sin(0.9)], [-np.sin(0.9), np.cos(0.9)]]
    np.testing.assert_allclose(moved[..., :2], turned + np.array([3.0, -2.0]), atol=1e-9)
    np.testing.assert_allclose(moved[..., 3], at_origin[..., 3] + 0.9, atol=1e-9)
    np.testing.assert_allclose(moved[..., [2, 4]], at_origin[..., [2, 4]], atol=1e-12)


@pytest.mark.parametrize("intention", Intention)
@pytest.mark.parametrize("road_type", RoadType)
def test_the_cheapest_chain_costs_what_the_planner_finds(
    road_type: RoadType, intention: Intention
) -> None:
    problem = scenario(road_type=road_type, intention=intention)
    plan = MotionPrimitivePlanner().plan(problem)
    assert trajectory_bundle(problem).cost.min() == pytest.approx(plan.cost)


def test_what_touches_is_what_shapely_says_of_each_alone() -> None:
    problem = scenario(CAR, AHEAD, BEHIND)
    bundle = trajectory_bundle(problem)
    touching = bundle.touching(problem)
    some = np.random.default_rng(0).choice(len(touching), 150, replace=False)
    expected = [
        first_contact(states[:length], problem.obstacles, BMW_320I) is not None
        for states, length in zip(bundle.states[some], bundle.lengths[some], strict=True)
    ]
    assert touching[some].tolist() == expected
    assert 0.1 < touching.mean() < 0.9
    assert not bundle.touching(scenario(BEHIND)).any()
