"""A whole primitive at once against the tests of each of its states."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import shapely

from avsec_gym.planners.collision import FOR_EVER, CollisionWorld, collides, obstacle_world
from avsec_gym.planners.estimates import HeuristicLimits
from avsec_gym.planners.goal import goal_arrays, reaches
from avsec_gym.planners.primitives import MotionPrimitives, generate_primitives
from avsec_gym.planners.sweep import (
    _crosses,
    _is_far,
    drives_freely,
    edge_blocks,
    first_in_goal,
    may_meet,
    place_of,
    state_at,
)
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
    for _ in range(250):
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
    assert min(answers.values()) > 3


def _there(world: CollisionWorld, step: int) -> CollisionWorld:
    """The world without the obstacles whose last known state is over."""
    there = world.presence[:, 2] >= step
    rows = {name: column[there] for name, column in world._asdict().items() if name != "edges"}
    return CollisionWorld(**rows, edges=world.edges)


def test_the_first_state_in_a_goal() -> None:
    rng = np.random.default_rng(1)
    arrays, found, sorted_out = SLOW.arrays, 0, 0
    for _ in range(1000):
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
    assert 50 < found < 950
    assert sorted_out > 0.5 * (1000 - found)


def test_blocks_hold_their_segments_and_no_more() -> None:
    edges = np.random.default_rng(2).uniform(-50, 50, (37, 4))
    blocks = edge_blocks(edges)
    for b, part in enumerate((edges[:16], edges[16:32], edges[32:])):
        x, y = part[:, [0, 2]], part[:, [1, 3]]
        np.testing.assert_array_equal(blocks[b], (x.min(), x.max(), y.min(), y.max()))
    assert len(blocks) == 3
    assert len(edge_blocks(edges[:0])) == 0


@pytest.mark.parametrize(
    ("heading", "expected"),
    [
        # Up to 0.05 rad by 1 and the angle, which is less than a turn.
        (0.03, (1.0, 0.03)),
        (-0.05, (1.0, -0.05)),
        (0.05, (1.0, 0.05)),
        (2 * np.pi + 0.02, (1.0, 0.02)),
        (-2 * np.pi - 0.02, (1.0, -0.02)),
        # Beyond, as they are kept, but beyond a whole turn anew.
        (0.0501, (7.0, 8.0)),
        (-3.0, (7.0, 8.0)),
        (2 * np.pi + 1.0, (math.cos(1.0), math.sin(1.0))),
        (-2 * np.pi - 1.0, (math.cos(1.0), -math.sin(1.0))),
    ],
)
def test_a_node_is_placed_as_commonroad_io_does_in_reference_mode(
    heading: float, expected: tuple[float, float]
) -> None:
    pose = np.array([[9.0] * 6, [1.0, 2.0, heading, 7.0, 8.0, 9.0]])
    assert place_of(1, pose, True) == pytest.approx((1.0, 2.0, heading, *expected))
    assert place_of(1, pose, False) == (1.0, 2.0, heading, 7.0, 8.0)


_CIRCLE, _SPEEDS = (2.0, 0.5, 1.5), (7.0, 7.5)
"""2 m ahead, half a metre to the left, of 1.5 m; and the least and greatest speed."""


def _meets(
    x: float = 10.0,
    y: float = 0.5,
    heading: float = 0.0,
    step: int = 4,
    speeds: tuple[float, float] = _SPEEDS,
    goals: tuple[tuple[int, int], ...] = ((5, 8),),
) -> bool:
    """Of a goal at x of 10 to 14 m, y of -1 to 3 m, and 6 to 8 m/s; three states count."""
    count = len(goals)
    sweep = np.array([[99.0] * 5, [*_CIRCLE, *speeds]])
    return may_meet(
        x, y, math.cos(heading), math.sin(heading), step, 1, 3, sweep, np.array(goals),
        np.tile([0.0, 7.0, 6.0, 8.0], (count, 1)), np.tile([10.0, 14.0, -1.0, 3.0], (count, 1)),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("given", "near"),
    [
        ({"x": 6.51}, True), ({"x": 6.49}, False), ({"x": 13.49}, True), ({"x": 13.51}, False),
        ({"y": -2.99}, True), ({"y": -3.01}, False), ({"y": 3.99}, True), ({"y": 4.01}, False),
        # Turned to the left, the circle is 2 m to the north and half a metre to the west.
        ({"x": 9.01, "heading": np.pi / 2}, True), ({"x": 8.99, "heading": np.pi / 2}, False),
        ({"x": 15.99, "heading": np.pi / 2}, True), ({"x": 16.01, "heading": np.pi / 2}, False),
        ({"y": -4.49, "heading": np.pi / 2}, True), ({"y": -4.51, "heading": np.pi / 2}, False),
        ({"y": 2.49, "heading": np.pi / 2}, True), ({"y": 2.51, "heading": np.pi / 2}, False),
        ({"step": 7}, True), ({"step": 8}, False), ({"step": 2}, True), ({"step": 1}, False),
        ({"speeds": (5.0, 6.0)}, True), ({"speeds": (5.0, 5.9)}, False),
        ({"speeds": (8.0, 9.0)}, True), ({"speeds": (8.1, 9.0)}, False),
        ({"goals": ((0, 1), (5, 8))}, True), ({"goals": ((5, 8), (0, 1))}, True),
        ({"goals": ((0, 1), (9, 9))}, False), ({"goals": ()}, False),
    ],
)  # fmt: skip
def test_a_way_comes_near_a_goal(given: dict[str, Any], near: bool) -> None:
    assert _meets() is True
    if given.get("goals") == ():
        given = {}
        empty = np.zeros((0, 2), np.int64), np.zeros((0, 4)), np.zeros((0, 4))
        assert not may_meet(10, 0, 1.0, 0.0, 4, 0, 3, np.ones((1, 5)), *empty)
    else:
        assert _meets(**given) == near


def _straight(count: int = 5) -> tuple[np.ndarray, np.ndarray]:
    """A primitive of 1 m a step, and the circle around its way."""
    states = np.zeros((1, count + 1, 7))
    states[0, :, 0], states[0, :, 2], states[0, :, 5] = np.arange(count + 1), 10.0, 1.0
    return states, np.array([[1.5 + 0.5 * (count + 1), 0.0, 0.5 * (count - 1), 10.0, 10.0]])


_CAR = HeuristicLimits(2.0, 1.0, 1.5, 0.1, 1.0)
"""Of 4 x 2 m, its centre 1.5 m before the rear axle: its front is from 4.5 to 8.5 m on the way."""


def _crates(
    *tracks: list[tuple[float, float]], first: int = 0, last: int | None = None
) -> CollisionWorld:
    """Crates of 1 x 1 m on their ways; a single place stands, if none says when it comes."""
    count = max(map(len, tracks))
    poses = np.zeros((len(tracks), count, 4))
    poses[..., 2] = 1.0
    for i, track in enumerate(tracks):
        poses[i, : len(track), :2] = track
    return CollisionWorld(
        np.tile([[0.5, -0.5], [0.5, 0.5], [-0.5, 0.5], [-0.5, -0.5]], (len(tracks), 1, 1)),
        np.full(len(tracks), 4),
        np.tile([0.0, math.sqrt(0.5)], (len(tracks), 1)),
        poses,
        np.array(
            [
                (first, len(track), first + len(track) - 1 if last is None else last)
                for track in tracks
            ]
        ),
        np.zeros((0, 4)),
    )


def _is_free(world: CollisionWorld, start: int = 10, reference: bool = False) -> bool:
    states, sweep = _straight()
    # As if the start had been placed, too.
    place, placed = (0.0, 0.0, 0.0, 1.0, 0.0), np.tile([1.5, 0.0, 1.0, 0.0, 1.0], (6, 1))
    blocks = edge_blocks(world.edges)
    return drives_freely(
        place, start, 0, 5, True, reference, states, sweep, _CAR, world, blocks, placed
    )


_AHEAD, _AWAY = (7.8, 0.0), (60.0, 0.0)
"""Where the vehicle's front comes in the fourth step, 7.3 m from its rear axle's start; away."""


@pytest.mark.parametrize(
    ("first", "free"), [(0, False), (11, False), (13, False), (14, False), (15, False), (16, True)]
)
def test_what_comes_into_being_on_the_way_is_touched_from_then_on(first: int, free: bool) -> None:
    assert _is_free(_crates([_AHEAD, _AHEAD], first=first)) == free
    # Also where another one, not there yet either, comes before it in the list, or after.
    assert _is_free(_crates([_AWAY, _AWAY], [_AHEAD, _AHEAD], first=first)) == free


@pytest.mark.parametrize(("last", "free"), [(11, True), (13, True), (14, False), (15, False)])
def test_what_is_gone_is_touched_no_more_in_reference_mode(last: int, free: bool) -> None:
    crate = _crates([_AHEAD] * 4, first=8, last=last)
    assert _is_free(crate, reference=True) == free
    assert not _is_free(crate)


@pytest.mark.parametrize(
    ("track", "free"),
    [
        # Far first, and there in time: at its first step, or when it is met.
        ([_AWAY, _AHEAD], False),
        ([_AWAY] * 5 + [_AHEAD], False),
        ([_AWAY] * 4 + [_AHEAD] + [_AWAY], False),
        # It leaves before the vehicle comes, or what is known of it at last is away.
        ([_AHEAD] * 3 + [_AWAY], True),
        ([_AHEAD, _AWAY], True),
        ([_AWAY], True),
        ([_AHEAD], False),
        # On the way at the start alone, which does not count.
        ([(-0.9, 0.0), _AWAY], True),
        ([_AWAY, (-0.9, 0.0)], True),
        ([_AWAY, (0.2, 0.0)], False),
    ],
)
def test_what_moves_is_met_where_it_is_then(track: list[tuple[float, float]], free: bool) -> None:
    assert _is_free(_crates(track, first=10)) == free
    assert _is_free(_crates([_AWAY, _AWAY], track, first=10)) == free


@pytest.mark.parametrize(
    ("x", "y", "free"),
    [
        (8.99, 0.0, False), (9.01, 0.0, True), (0.01, 0.0, False), (-0.01, 0.0, True),
        (5.0, 1.49, False), (5.0, 1.51, True), (5.0, -1.49, False), (5.0, -1.51, True),
        (8.9, 1.4, False), (9.1, 1.6, True),
    ],
)  # fmt: skip
def test_crates_beside_the_way_stand_as_near_as_they_touch(x: float, y: float, free: bool) -> None:
    assert _is_free(_crates([(x, y)], last=10**6)) == free


@pytest.mark.parametrize(
    ("edge", "free"),
    [
        ((8.49, -9.0, 8.49, 9.0), False), ((8.51, -9.0, 8.51, 9.0), True),
        ((-9.0, 1.01, 30.0, 1.01), True), ((-9.0, 0.99, 30.0, 0.99), False),
        ((-9.0, -0.99, 30.0, -0.99), False), ((-9.0, -1.01, 30.0, -1.01), True),
        # Behind the first step; before it, the start touches it, which does not count.
        ((0.51, -9.0, 0.51, 9.0), False), ((0.49, -9.0, 0.49, 9.0), True),
        ((-0.3, -9.0, -0.3, 9.0), True),
        # What ends beside the way, and what runs past its corner.
        ((5.0, 1.01, 5.0, 9.0), True), ((5.0, 0.99, 5.0, 9.0), False),
        ((7.6, 2.0, 9.6, 0.0), True), ((7.4, 2.0, 9.4, 0.0), False),
    ],
)  # fmt: skip
def test_the_road_edge_is_as_near_as_it_touches(
    edge: tuple[float, float, float, float], free: bool
) -> None:
    far = [(100.0 + k, 0.0, 101.0 + k, 1.0) for k in range(20)]
    for edges in ([edge], [*far, edge], [edge, *far]):
        world = _crates([_AWAY], last=10**6)._replace(edges=np.array(edges))
        assert _is_free(world) == free


@pytest.mark.parametrize("seed", range(3))
def test_segments_are_far_where_their_line_or_both_ends_are(seed: int) -> None:
    rng, answers = np.random.default_rng(seed), []
    for _ in range(300):
        edges = rng.uniform(-9, 9, (2, 4))
        x, y = rng.uniform(-4, 4, 2)
        reach = float(rng.uniform(0.3, 6.0))
        a, b = edges[1, :2] - (x, y), edges[1, 2:] - (x, y)
        line = abs(a[0] * b[1] - a[1] * b[0]) / np.hypot(*(b - a))
        beside = bool((np.minimum(a, b) > reach).any() or (np.maximum(a, b) < -reach).any())
        far = _is_far(x, y, reach, edges, 1)
        assert far == (beside or line > reach)
        # What is near is never far.
        distance = shapely.LineString(edges[1].reshape(2, 2)).distance(shapely.Point(x, y))
        assert not far or distance > reach
        answers.append(far)
    assert 50 < sum(answers) < 250


@pytest.mark.parametrize(
    ("edge", "far"),
    [
        ((2.0, -1.0, 2.0, 1.0), False), ((2.01, -1.0, 2.01, 1.0), True),
        ((-2.0, -1.0, -2.0, 1.0), False), ((-2.01, -1.0, -2.01, 1.0), True),
        ((-1.0, 2.0, 1.0, 2.0), False), ((-1.0, 2.01, 1.0, 2.01), True),
        ((-1.0, -2.0, 1.0, -2.0), False), ((-1.0, -2.01, 1.0, -2.01), True),
        ((2.8, 0.0, 0.0, 2.8), False), ((2.9, 0.0, 0.0, 2.9), True),
        ((-2.8, 0.0, 0.0, -2.8), False), ((-2.9, 0.0, 0.0, -2.9), True),
        ((9.0, 0.0, 1.9, 0.0), False), ((0.0, -9.0, 0.0, -1.9), False),
    ],
)  # fmt: skip
def test_a_segment_that_touches_a_circle_of_two_metres_is_not_far(
    edge: tuple[float, float, float, float], far: bool
) -> None:
    edges = np.add([edge], [5.0, 7.0, 5.0, 7.0])
    assert _is_far(5.0, 7.0, 2.0, edges, 0) == far


def test_lines_cross_where_shapely_finds_it() -> None:
    rng, answers = np.random.default_rng(4), []
    for _ in range(600):
        edges, way = rng.uniform(-3, 3, (2, 4)), rng.uniform(-3, 3, 4)
        lines = (shapely.LineString(each.reshape(2, 2)) for each in (edges[1], way))
        expected = shapely.intersects(*lines)
        assert _crosses(*way, edges, 1) == expected
        answers.append(expected)
    assert 60 < sum(answers) < 300


@pytest.mark.parametrize("reference", [False, True])
def test_a_state_is_turned_and_moved_with_the_start(reference: bool) -> None:
    rng = np.random.default_rng(5)
    states = rng.uniform(-2, 2, (3, 4, 7))
    states[..., 5], states[..., 6] = np.cos(states[..., 3]), np.sin(states[..., 3])
    heading = 0.8
    # In reference mode, places are turned by what is no rotation at small angles.
    turn = complex(1.0, heading) if reference else np.exp(1j * heading)
    place = (3.0, -4.0, heading, turn.real, turn.imag)
    x, y, _, own = states[2, 3, :4]
    moved = complex(3.0, -4.0) + turn * complex(x, y)
    expected = (moved.real, moved.imag, 0.8 + own, math.cos(0.8 + own), math.sin(0.8 + own))
    assert state_at(place, states, 2, 3, reference) == pytest.approx(expected, abs=1e-9)
