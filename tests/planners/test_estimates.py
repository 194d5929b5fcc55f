"""Times to goals at least, by hand and by shapely."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import shapely

from avsec_gym.planners.estimates import (
    _may_reach,
    distance_to_goals,
    heuristic_limits,
    steps_by_air,
    steps_in_time,
    steps_to_goal,
    time_to_aim,
)
from avsec_gym.planners.goal import goal_arrays
from avsec_gym.planners.primitives import generate_primitives
from avsec_gym.scenario.planning_scenario import Goal
from avsec_gym.scenario.shapes import Rectangle


@pytest.mark.parametrize(
    ("distance", "step", "expected"),
    [
        (0.0, 2.0, 1.0), (-1.0, 2.0, 1.0), (0.0, 0.0, 1.0), (1.0, 0.0, math.inf),
        (0.5, 2.0, 1.0), (2.0, 2.0, 1.0), (2.1, 2.0, 2.0), (4.0, 2.0, 2.0), (7.9, 2.0, 4.0),
        (8.1, 2.0, 5.0), (0.75, 0.5, 2.0),
    ],
)  # fmt: skip
def test_time_steps_by_air(distance: float, step: float, expected: float) -> None:
    assert steps_by_air(distance, step) == expected


@pytest.mark.parametrize("seed", range(3))
def test_the_distance_to_goals_is_that_to_the_nearest_box(seed: int) -> None:
    rng, inside = np.random.default_rng(seed), 0
    for _ in range(60):
        low, size = rng.uniform(-9, 9, (3, 2)), rng.uniform(0, 6, (3, 2))
        boxes = np.column_stack(
            [low[:, 0], low[:, 0] + size[:, 0], low[:, 1], low[:, 1] + size[:, 1]]
        )
        x, y = rng.uniform(-12, 12, 2)
        expected = min(
            shapely.box(x1, y1, x2, y2).distance(shapely.Point(x, y)) for x1, x2, y1, y2 in boxes
        )
        assert distance_to_goals(x, y, boxes) == pytest.approx(expected)
        inside += expected == 0.0
    assert 0 < inside < 60
    assert distance_to_goals(0.0, 0.0, np.zeros((0, 4))) == math.inf


def test_the_time_to_the_first_goal_at_the_present_speed() -> None:
    place = (Rectangle(4.0, 2.0, 10.0, 3.0),)
    goals = goal_arrays((Goal((8, 12), place), Goal((3, 5), (Rectangle(1.0, 1.0),))))
    # The box is 8 to 12 m ahead and 2 to 4 m aside.
    for x, y, away in (
        (5.0, 3.0, 3.0), (13.0, 2.5, 1.0), (10.0, 7.0, 3.0), (10.0, 1.0, 1.0), (5.0, -2.0, 5.0),
        (9.0, 3.5, 0.0),
    ):  # fmt: skip
        assert time_to_aim(x, y, 2.0, 4, goals) == pytest.approx(away / 2.0)
    assert time_to_aim(5.0, 3.0, 0.5, 4, goals) == pytest.approx(6.0)
    assert time_to_aim(5.0, 3.0, -2.0, 4, goals) == pytest.approx(-1.5)
    for standing in (0.0, 1e-9, -1e-9):
        assert time_to_aim(5.0, 3.0, standing, 4, goals) == math.inf
    assert time_to_aim(5.0, 3.0, 1e-3, 4, goals) == pytest.approx(3000.0)
    anywhere = goal_arrays((Goal((8, 12)), Goal((3, 5), place)))
    for step, steps in ((3, 5.0), (8, 0.0), (10, -2.0)):
        assert time_to_aim(5.0, 3.0, 2.0, step, anywhere) == steps


@pytest.mark.parametrize(
    ("nearest", "step", "windows", "expected"),
    [
        (3.0, 2, [(4, 9)], 3.0),
        (1.0, 2, [(4, 9)], 2.0),
        (7.0, 2, [(4, 9)], 7.0),
        (8.0, 2, [(4, 9)], math.inf),
        (1.0, 2, [(9, 11), (4, 5)], 2.0),
        (4.0, 2, [(9, 11), (4, 5)], 7.0),
        (10.0, 2, [(9, 11), (4, 5)], math.inf),
        (1.0, 20, [(9, 11)], math.inf),
        (math.inf, 2, [(4, 9)], math.inf),
    ],
)
def test_time_steps_to_the_soonest_window(
    nearest: float, step: int, windows: list[tuple[int, int]], expected: float
) -> None:
    assert steps_in_time(nearest, step, np.array(windows)) == expected


_REACH = np.zeros((2, 9, 6))
"""What is reached of the second primitive: from the third step on 1 m more each, 2 m aside."""
for _step in range(9):
    _REACH[0, _step] = (1.0, -1.0, 0.0, 0.0, 0.0, 0.0)
    _REACH[1, _step] = (1.0, -1.0 if _step < 3 else float(_step), -2.0, 2.0, -0.2, 0.3)


def _steps_to(
    box: tuple[float, float, float, float] = (5.0, 7.0, -1.0, 1.0),
    window: tuple[int, int] = (0, 20),
    heading: tuple[float, float] = (-0.5, 0.5),
    nearest: float = 1.0,
    follow: int = 1,
    further: tuple[tuple[int, int], ...] = (),
) -> float:
    windows = np.array([window, *further])
    count = len(windows)
    intervals = np.tile([heading[0], heading[1] - heading[0], 0.0, 9.0], (count, 1))
    # From (100, 50), to the north; the goals are that far ahead and to the left.
    x1, x2, y1, y2 = box
    boxes = np.tile([100.0 - y2, 100.0 - y1, 50.0 + x1, 50.0 + x2], (count, 1))
    intervals[:, 0] += np.pi / 2
    return steps_to_goal(
        100.0, 50.0, np.pi / 2, 0.0, 1.0, 10, follow, nearest, windows + 10, intervals, boxes,
        _REACH,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        # The box begins 5 m ahead, and is reached in five steps.
        ({"window": (0, 8)}, 5.0),
        ({"window": (6, 8)}, 6.0),
        ({"window": (0, 4)}, math.inf),
        ({"window": (0, 5)}, 5.0),
        ({"window": (0, 8), "nearest": 7.0}, 7.0),
        ({"window": (0, 6), "nearest": 7.0}, math.inf),
        ({"window": (0, 8), "follow": 0}, math.inf),
        ({"window": (0, 8), "box": (1.5, 2.0, 0.0, 1.0)}, 3.0),
        # Another window, sooner or later than the first.
        ({"window": (7, 8), "further": ((6, 6),)}, 6.0),
        ({"window": (6, 8), "further": ((7, 8),)}, 6.0),
        ({"window": (0, 3), "further": ((7, 8),)}, 7.0),
        ({"window": (0, 8), "further": ((0, 8),)}, 5.0),
        # Beside what is reached, or just within it; behind.
        ({"window": (0, 8), "box": (5.0, 7.0, 1.99, 3.0)}, 5.0),
        ({"window": (0, 8), "box": (5.0, 7.0, 2.01, 3.0)}, math.inf),
        ({"window": (0, 8), "box": (5.0, 7.0, -3.0, -1.99)}, 5.0),
        ({"window": (0, 8), "box": (5.0, 7.0, -3.0, -2.01)}, math.inf),
        ({"window": (0, 8), "box": (-2.0, 0.99, -1.0, 1.0)}, math.inf),
        ({"window": (0, 8), "box": (-2.0, 1.01, -1.0, 1.0)}, 3.0),
        ({"window": (0, 8), "box": (5.01, 7.0, -1.0, 1.0)}, 6.0),
        ({"window": (0, 8), "box": (4.99, 7.0, -1.0, 1.0)}, 5.0),
        # Headings from 0.2 to the right up to 0.3 to the left are reached.
        ({"window": (0, 8), "heading": (0.29, 0.5)}, 5.0),
        ({"window": (0, 8), "heading": (0.31, 0.5)}, math.inf),
        ({"window": (0, 8), "heading": (-0.5, -0.19)}, 5.0),
        ({"window": (0, 8), "heading": (-0.5, -0.21)}, math.inf),
        ({"window": (0, 8), "heading": (0.0, 0.1)}, 5.0),
        ({"window": (0, 8), "heading": (2 * np.pi + 0.1, 2 * np.pi + 0.2)}, 5.0),
        ({"window": (0, 8), "heading": (2.0, 6.0)}, math.inf),
        ({"window": (0, 8), "heading": (2.0, 2 * np.pi - 0.19)}, 5.0),
    ],
)
def test_time_steps_to_goals_by_a_table_of_what_is_reached(
    given: dict[str, Any], expected: float
) -> None:
    assert _steps_to(**given) == expected


def test_a_goal_anywhere_is_reached_at_the_first_step_that_reaches_anything() -> None:
    windows, intervals = np.array([[0, 8]]), np.array([[-9.0, 2 * np.pi, 0.0, 9.0]])
    everywhere = np.array([[-np.inf, np.inf, -np.inf, np.inf]])
    steps = steps_to_goal(
        7.0, 8.0, 0.4, 0.9, 0.4, 0, 1, 1.0, windows, intervals, everywhere, _REACH
    )
    assert steps == 3.0


@pytest.mark.parametrize("seed", range(3))
def test_a_goal_may_be_reached_where_two_rectangles_meet(seed: int) -> None:
    rng, answers = np.random.default_rng(seed), []
    for _ in range(150):
        x, y, heading = rng.uniform(-5, 5, 3)
        x1, y1, goal_x, goal_y = rng.uniform(-6, 6, 4)
        length, width, goal_length, goal_width = rng.uniform(0.1, 5, 4)
        turn = np.exp(1j * heading)
        corners = [
            complex(x, y) + turn * complex(a, b)
            for a, b in (
                (x1, y1), (x1 + length, y1), (x1 + length, y1 + width), (x1, y1 + width),
            )
        ]  # fmt: skip
        reached = shapely.Polygon([(corner.real, corner.imag) for corner in corners])
        goal = shapely.box(goal_x, goal_y, goal_x + goal_length, goal_y + goal_width)
        found = _may_reach(
            x, y, heading, turn.real, turn.imag,
            np.array([x1, x1 + length, y1, y1 + width, 0.0, 0.1]), 1,
            np.array([[9.0] * 4, [heading, 1.0, 0.0, 9.0]]),
            np.array([[9.0] * 4, [goal_x, goal_x + goal_length, goal_y, goal_y + goal_width]]),
        )  # fmt: skip
        assert found == reached.intersects(goal)
        answers.append(bool(found))
    assert 8 < sum(answers) < 142


def test_the_limits_are_those_of_the_vehicle_and_of_the_longest_step() -> None:
    primitives = generate_primitives((6.0, 8.0))
    limits, vehicle = heuristic_limits(primitives), primitives.vehicle
    assert limits[:4] == (vehicle.length / 2, vehicle.width / 2, vehicle.rear_axle, primitives.dt)
    longest = 0.0
    for states in primitives.states:
        places = [
            complex(x, y) + vehicle.rear_axle * np.exp(1j * own) for x, y, _, own, _ in states
        ]
        longest = max(longest, *np.abs(np.diff(places)))
    assert limits.step_distance == pytest.approx(longest)
