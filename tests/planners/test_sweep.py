"""A whole primitive at once against the tests of each of its states."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.planners.collision import FOR_EVER, CollisionWorld, collides, obstacle_world
from avsec_gym.planners.estimates import HeuristicLimits
from avsec_gym.planners.goal import goal_arrays, reaches
from avsec_gym.planners.primitives import MotionPrimitives, generate_primitives
from avsec_gym.planners.sweep import drives_freely, edge_blocks, first_in_goal, may_meet
from avsec_gym.planners.vehicle import BMW_320I
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.planning_scenario import Goal
from avsec_gym.scenario.road import Lanelet, Road, straight_lanes
from avsec_gym.scenario.shapes import Disc, Polygon, Rectangle

LIMITS = HeuristicLimits(BMW_320I.length / 2, BMW_320I.width / 2, BMW_320I.rear_axle, 0.1, 5.0)
SLOW, FAST = generate_primitives((6.0, 8.0)), generate_primitives((40.0, 50.0), steering_angles=5)
BAR = ((20.0, -20.0), (20.0, 20.0), (20.4, 20.0), (20.4, -20.0))
"""A bar across the way, thinner than what a fast car drives in one time step."""
ROADS = {
    "none": np.zeros((0, 4)),
    "lanes": Road(straight_lanes(2, 3.5, -10.0, 60.0)).edges,
    "fork": Road(
        (
            *straight_lanes(1, 3.0, -10, 40),
            Lanelet(9, left=((0, 1.5), (35, 14)), right=((0, -1.5), (35, 10))),
        )
    ).edges,
    "bar": np.vstack(
        [
            Road(straight_lanes(3, 15.0, -30.0, 90.0)).edges,
            [(*BAR[k], *BAR[(k + 1) % 4]) for k in range(4)],
        ]
    ),
}


def random_world(rng: np.random.Generator, edges: np.ndarray) -> CollisionWorld:
    count = int(rng.integers(0, 6))
    poses = np.column_stack([rng.uniform(-5, 25, count), rng.uniform(-8, 8, count)])
    poses = np.column_stack([poses, rng.uniform(-4, 4, count)])
    obstacles = Obstacles.rectangles(
        poses,
        rng.uniform(0.5, 6, count),
        rng.uniform(0.2, 3, count),
        rng.choice([0.0, 0.0, 4.0, 15.0], count),
        last_step=int(rng.integers(2, 9)),
    )
    shapes = tuple(
        shape if rng.random() < 0.7 else Disc(float(rng.uniform(0.3, 2)), 0.5)
        for shape in obstacles.shapes
    )
    first = np.where(obstacles.static, 0, rng.integers(0, 5, count))
    return obstacle_world(replace(obstacles, shapes=shapes, first_step=first), edges)


def states_of(
    primitives: MotionPrimitives, place: tuple[float, ...], p: int
) -> list[tuple[float, float, float, float]]:
    """Centre, heading and velocity at every state but the first."""
    x, y, heading, cos, sin = place
    states = []
    for px, py, velocity, turn, _ in primitives.states[p, 1 : primitives.steps[p] + 1]:
        qx, qy = cos * px - sin * py + x, sin * px + cos * py + y
        axle = BMW_320I.rear_axle
        own = heading + turn
        states.append((qx + axle * math.cos(own), qy + axle * math.sin(own), own, velocity))
    return states


@pytest.mark.parametrize("road", ROADS)
@pytest.mark.parametrize("primitives", [SLOW, FAST], ids=["slow", "fast"])
def test_a_primitive_is_free_where_all_its_states_are(
    road: str, primitives: MotionPrimitives
) -> None:
    rng = np.random.default_rng(len(road))
    arrays, edges = primitives.arrays, ROADS[road]
    placed = np.empty((arrays.states.shape[1], 5))
    half = LIMITS.half_length, LIMITS.half_width
    answers = {True: 0, False: 0}
    for _ in range(1500):
        world, reference = random_world(rng, edges), bool(rng.random() < 0.5)
        if reference:  # What moves is gone after its last known state.
            expected_world = world
        else:
            presence = world.presence.copy()
            presence[:, 2] = FOR_EVER
            expected_world = world._replace(presence=presence)
        heading = float(rng.choice([0.0, 0.03, rng.uniform(-4, 4)]))
        x, y = rng.uniform(-5, 22), rng.uniform(-5, 5)
        cos, sin = math.cos(heading), math.sin(heading)
        centre = x + BMW_320I.rear_axle * cos, y + BMW_320I.rear_axle * sin
        step, p = int(rng.integers(0, 12)), int(rng.integers(len(primitives)))
        if reference and abs(heading) <= 0.05:
            cos, sin = 1.0, heading
        place = (x, y, heading, cos, sin)
        edge_only = world._replace(poses=world.poses[:0])
        on_road = not collides(*centre, math.cos(heading), math.sin(heading), *half, 0, edge_only)
        free = drives_freely(
            place, step, p, arrays.steps[p], on_road, reference, arrays.states, arrays.sweep,
            LIMITS, world, edge_blocks(world.edges), placed,
        )  # fmt: skip
        expected = not any(
            collides(cx, cy, math.cos(own), math.sin(own), *half, step + j, gone)
            for j, (cx, cy, own, _) in enumerate(states_of(primitives, place, p), start=1)
            for gone in [_there(expected_world, step + j)]
        )
        assert free == expected
        answers[free] += 1
    assert min(answers.values()) > 20


def _there(world: CollisionWorld, step: int) -> CollisionWorld:
    """The world without the obstacles whose last known state is over."""
    there = world.presence[:, 2] >= step
    rows = {name: column[there] for name, column in world._asdict().items() if name != "edges"}
    return CollisionWorld(**rows, edges=world.edges)


def test_the_first_state_in_a_goal() -> None:
    rng = np.random.default_rng(1)
    arrays, found, sorted_out = SLOW.arrays, 0, 0
    for _ in range(2000):
        x, y, heading = rng.uniform(-5, 12), rng.uniform(-4, 4), rng.uniform(-1, 1)
        regions = (Rectangle(4.0, 3.0, 8.0, 0.5, 0.4), Disc(1.5, 8.0), None)
        triangle = Polygon(((6.0, -2.0), (11.0, -2.0), (8.0, 3.0)))
        region = (*regions, triangle)[int(rng.integers(4))]
        first = int(rng.integers(0, 8))
        goals = goal_arrays(
            (
                Goal((first, first + 3), region and (region,), (-0.6, 0.6)),
                Goal((3, 5), (Disc(0.5, 3.0, 3.0),), velocity=(7.0, 8.0)),
            )
        )
        place = (x, y, heading, math.cos(heading), math.sin(heading))
        step, p = int(rng.integers(0, 9)), int(rng.integers(len(SLOW)))
        answer = first_in_goal(
            place, step, p, arrays.steps[p], False, LIMITS.centre_offset, arrays.states, goals
        )
        expected = [
            j
            for j, state in enumerate(states_of(SLOW, place, p), start=1)
            if reaches(*state, step + j, goals)
        ]
        assert answer == (expected[0] if expected else -1)
        found += bool(expected)
        # What is sorted out beforehand never meets a goal; most that does not is sorted out.
        near = may_meet(
            x, y, place[3], place[4], step, p, arrays.steps[p], arrays.sweep, goals.steps,
            goals.intervals, goals.boxes,
        )  # fmt: skip
        assert near or not expected
        sorted_out += not near
    assert 100 < found < 1900
    assert sorted_out > 0.5 * (2000 - found)


def test_blocks_hold_their_segments_and_no_more() -> None:
    edges = np.random.default_rng(2).uniform(-50, 50, (37, 4))
    blocks = edge_blocks(edges)
    for b, part in enumerate((edges[:16], edges[16:32], edges[32:])):
        x, y = part[:, [0, 2]], part[:, [1, 3]]
        np.testing.assert_array_equal(blocks[b], (x.min(), x.max(), y.min(), y.max()))
    assert len(blocks) == 3
    assert len(edge_blocks(edges[:0])) == 0
