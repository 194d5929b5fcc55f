"""The tree that pictures show: what it holds was driven, by shapely."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from avsec_gym.geometry import rectangle_corners
from avsec_gym.planners import planner as planner_module
from avsec_gym.planners.planner import MotionPrimitivePlanner
from avsec_gym.planners.primitives import MotionPrimitives, generate_primitives
from avsec_gym.planners.search_state import (
    GOAL,
    NODES,
    PARENT,
    PRIMITIVE,
    REFUSED,
    STEP,
    SearchState,
)
from avsec_gym.planners.search_tree import search_tree
from avsec_gym.planners.vehicle import BMW_320I
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.planning_scenario import EgoState, Goal, PlanningScenario
from avsec_gym.scenario.shapes import Rectangle

_LENGTH, _WIDTH = 3.0, 1.8


def crossing(seed: int) -> PlanningScenario:
    """Five obstacles that cross the way to a small goal."""
    rng, count = np.random.default_rng(seed), 5
    places = rng.uniform(5, 30, count), rng.uniform(-8, 8, count)
    poses = np.stack([*places, rng.choice([np.pi / 2, -np.pi / 2], count)], axis=1)
    sizes = np.full(count, _LENGTH), np.full(count, _WIDTH)
    obstacles = Obstacles.rectangles(poses, *sizes, rng.uniform(1, 6, count), last_step=30)
    region = (Rectangle(2.0, 2.0, x=20.0, y=0.5),)
    goal = Goal((20, 25), region, (-0.05, 0.05))
    return PlanningScenario("crossing", EgoState(0, 0, 6, 0, 0, 0), (goal,), obstacles=obstacles)


def colliding(scenario: PlanningScenario, primitives: MotionPrimitives, state: SearchState) -> int:
    """How many nodes that were not refused lie on a way that touches an obstacle."""
    rows, arrays = [], primitives.arrays
    for node in range(1, state.counters[NODES]):
        parent, own, goal_index = state.link[node, [PARENT, PRIMITIVE, GOAL]]
        if goal_index == REFUSED:
            continue
        count = arrays.steps[own] if goal_index < 0 else goal_index
        x, y, heading = state.pose[parent, :3]
        ahead, left, _, turned = arrays.states[own, 1 : count + 1, :4].T
        turned = turned + heading
        x = x + np.cos(heading) * ahead - np.sin(heading) * left
        y = y + np.sin(heading) * ahead + np.cos(heading) * left
        x, y = x + BMW_320I.rear_axle * np.cos(turned), y + BMW_320I.rear_axle * np.sin(turned)
        step = state.link[parent, STEP] + np.arange(1, count + 1)
        rows.append(np.stack([x, y, turned, step, np.full(count, node)], axis=1))
    ways = np.concatenate(rows)
    car = shapely.polygons(rectangle_corners(ways[:, :3], BMW_320I.length, BMW_320I.width))
    touched = np.zeros(len(ways), bool)
    for track in scenario.obstacles.poses:
        there = track[np.minimum(ways[:, 3].astype(int), len(track) - 1)]
        obstacle = shapely.polygons(rectangle_corners(there, _LENGTH, _WIDTH))
        touched |= shapely.intersects(car, obstacle)
    return len(np.unique(ways[touched, 4]))


@pytest.mark.parametrize("seed", [pytest.param(204, marks=pytest.mark.slow), 254, 283])
def test_no_way_of_the_tree_collides(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    # In these, states that were expanded before are met again on ways that collide.
    states: list[SearchState] = []

    def kept(state: SearchState, centre_offset: float) -> object:
        states.append(state)
        return search_tree(state, centre_offset)

    monkeypatch.setattr(planner_module, "search_tree", kept)
    primitives = generate_primitives((4.0, 6.0, 8.0, 10.0), steering_angles=13)
    scenario = crossing(seed)
    plan = MotionPrimitivePlanner(primitives=primitives, keep_tree=True).plan(scenario)
    assert plan.tree is not None
    assert len(plan.tree) > 50
    assert colliding(scenario, primitives, states[0]) == 0
