"""The swept check, against time cut into milliseconds and against cases worked out by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely

from avsec_gym.geometry import Floats
from avsec_gym.metrics.collision_check import Contact, first_contact
from avsec_gym.metrics.safety import SafetyRates, judge
from avsec_gym.metrics.swept_contact import (
    TOLERANCE,
    _deviation,
    _Steps,
    first_swept_contact,
)
from avsec_gym.planners.plan import Plan, Status
from avsec_gym.planners.vehicle import BMW_320I
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.planning_scenario import EgoState, PlanningScenario
from avsec_gym.scenario.shapes import Disc, placed

_MILLISECONDS = 100
"""In a time step."""


def driven(speed: float, curvature: float = 0.0, steps: int = 12) -> Floats:
    """A circle, or a straight line, from the origin on; one state every 0.1 s."""
    way = speed * 0.1 * np.arange(steps + 1)
    heading = curvature * way
    states = np.zeros((steps + 1, 5))
    states[1:, 0] = np.cumsum(speed * 0.1 * np.cos(heading[:-1]))
    states[1:, 1] = np.cumsum(speed * 0.1 * np.sin(heading[:-1]))
    states[:, 3] = heading
    return states


def clearance(trajectory: Floats, truth: Obstacles) -> float:
    """Metres between vehicle and obstacles, the least over every millisecond."""
    least = math.inf
    for i, shape in enumerate(truth.shapes):
        for t in range(len(trajectory) - 1):
            for part in range(_MILLISECONDS + 1):
                share = part / _MILLISECONDS
                x, y, heading = _between(trajectory[:, [0, 1, 3]], t, share)
                rows = truth.poses[i, : truth.steps[i]]
                pose = _between(rows, min(t, len(rows) - 1), share)
                box = shapely.box(-2.254, -0.805, 2.254, 0.805)
                box = shapely.affinity.rotate(box, heading, (0, 0), use_radians=True)
                box = shapely.affinity.translate(box, x, y)
                least = min(least, box.distance(placed(shape, pose)))
    return least


def _between(poses: Floats, row: int, share: float) -> Floats:
    after = poses[min(row + 1, len(poses) - 1)]
    turn = math.remainder(after[2] - poses[row][2], 2 * math.pi)
    return poses[row] + share * np.array([*(after - poses[row])[:2], turn])


def turning(draw: np.random.Generator, steps: int = 13) -> Obstacles:
    """A car that drives a curve, across where the vehicle drives."""
    start = np.array([draw.uniform(3, 10), draw.uniform(-5, 5), draw.uniform(-3, 3)])
    speed, rate = draw.uniform(0, 15), draw.uniform(-1.0, 1.0)
    poses = [start]
    for _ in range(steps - 1):
        x, y, h = poses[-1]
        poses.append(
            np.array([x + 0.1 * speed * np.cos(h), y + 0.1 * speed * np.sin(h), h + 0.1 * rate])
        )
    one = Obstacles.rectangles(
        start[None], np.array([draw.uniform(0.2, 4)]), np.array([draw.uniform(0.1, 1.8)]),
        np.array([1.0]), last_step=steps - 1,
    )  # fmt: skip
    return Obstacles(
        one.ids, one.categories, one.shapes, np.array([poses]), one.speeds,
        one.steps, one.first_step, one.static,
    )  # fmt: skip


@pytest.mark.parametrize("seed", range(24))
def test_it_agrees_with_every_millisecond(seed: int) -> None:
    draw = np.random.default_rng(seed)
    trajectory = driven(draw.uniform(3, 15), draw.uniform(-0.2, 0.2), steps=6)
    truth = turning(draw, 7)
    if seed % 3 == 0:  # One that stands, too.
        truth = Obstacles.rectangles(
            np.array([[draw.uniform(2, 8), draw.uniform(-2, 2), draw.uniform(-3, 3)]]),
            np.array([draw.uniform(0.1, 4)]),
            np.array([0.3]),
        )
    least = clearance(trajectory, truth)
    touched = first_swept_contact(trajectory, truth, BMW_320I) is not None
    # In a millisecond they come 15 mm closer at most, from either side.
    if touched:
        assert least <= 0.015 + TOLERANCE
    else:
        assert least > 0


def test_the_millimetres_of_a_near_miss_are_kept() -> None:
    """Straight past a wall: exact, however far a step reaches."""
    trajectory = driven(15.0)
    for gap, touched in ((0.0005, False), (-0.0005, True)):
        wall = Obstacles.rectangles(
            np.array([[5.0, 0.805 + 0.5 + gap, 0.0]]), np.array([0.01]), np.array([1.0])
        )
        assert (first_swept_contact(trajectory, wall, BMW_320I) is not None) is touched


def test_what_passes_between_two_steps_is_seen() -> None:
    """A pole that a car 4.5 m long jumps over at 60 m/s."""
    trajectory = driven(60.0, steps=3)
    pole = Obstacles.rectangles(np.array([[3.0, 0.0, 0.0]]), np.array([0.1]), np.array([0.1]))
    assert first_contact(trajectory, pole, BMW_320I) is None
    assert first_swept_contact(trajectory, pole, BMW_320I) == Contact(0, 0)
    assert first_swept_contact(trajectory, pole, BMW_320I, first_step=4) == Contact(4, 0)
    beside = Obstacles.rectangles(np.array([[3.0, 0.9, 0.0]]), np.array([0.1]), np.array([0.1]))
    assert first_swept_contact(trajectory, beside, BMW_320I) is None


def test_two_that_drive_are_seen_where_they_meet() -> None:
    """A car crosses behind the vehicle: the hulls on the road overlap, the two never meet."""
    trajectory = driven(40.0, steps=2)
    crossing = Obstacles.rectangles(
        np.array([[-0.5, -4.5, np.pi / 2]]), np.array([1.0]), np.array([0.4]), np.array([40.0]),
        last_step=2,
    )  # fmt: skip
    assert clearance(trajectory, crossing) > 0.02
    assert first_swept_contact(trajectory, crossing, BMW_320I) is None
    later = Obstacles.rectangles(
        np.array([[4.5, -4.5, np.pi / 2]]), np.array([1.0]), np.array([0.4]), np.array([40.0]),
        last_step=2,
    )  # fmt: skip
    assert clearance(trajectory, later) == 0
    assert first_swept_contact(trajectory, later, BMW_320I) is not None


def test_no_sampled_contact_is_missed() -> None:
    for seed in range(200):
        draw = np.random.default_rng(seed)
        trajectory = driven(draw.uniform(3, 15), draw.uniform(-0.2, 0.2))
        truth = turning(draw)
        sampled = first_contact(trajectory, truth, BMW_320I)
        swept = first_swept_contact(trajectory, truth, BMW_320I)
        if sampled is not None:
            assert swept is not None
            assert swept.step <= sampled.step
    empty = Obstacles.none()
    assert first_swept_contact(driven(5.0), empty, BMW_320I) is None
    assert first_swept_contact(driven(5.0)[:1], turning(draw), BMW_320I) is None


def test_where_both_head_is_no_part_of_how_far_they_are_apart() -> None:
    """What a corner leaves its straight way by hangs on turns and places, not on headings."""
    rng = np.random.default_rng(4)
    own, change, other, other_change = rng.uniform(-3, 3, (4, 20, 3))
    turned = own + np.array([0.0, 0.0, 100.0])
    steps = [_Steps(each, change, other, other_change) for each in (own, turned)]
    np.testing.assert_array_equal(*(_deviation(each, 2.0) for each in steps))


def test_other_shapes_and_late_comers() -> None:
    trajectory = driven(60.0, steps=3)
    pole = Obstacles.rectangles(np.array([[3.0, 0.0, 0.0]]), np.array([0.1]), np.array([0.1]))
    disc = Obstacles(
        pole.ids, pole.categories, (Disc(0.1),), pole.poses, pole.speeds, pole.steps,
        pole.first_step, pole.static,
    )  # fmt: skip
    assert first_swept_contact(trajectory, disc, BMW_320I) == Contact(0, 0)
    late = Obstacles(
        pole.ids, pole.categories, pole.shapes, pole.poses, pole.speeds, pole.steps,
        np.array([1]), np.array([False]),
    )  # fmt: skip
    assert first_swept_contact(trajectory, late, BMW_320I) is None


def test_the_record_has_both_and_the_steps_decide() -> None:
    scenario = PlanningScenario("1", EgoState(velocity=60.0), ())
    plan = Plan(Status.FOUND, driven(60.0, steps=3), 0, 1, cost=0.3)
    pole = Obstacles.rectangles(np.array([[3.0, 0.0, 0.0]]), np.array([0.1]), np.array([0.1]))
    record = judge(plan, scenario, pole)
    assert record.safe
    assert record.swept_collision is True
    clear = judge(plan, scenario, Obstacles.none())
    assert clear.swept_collision is False
    unplanned = judge(Plan(Status.EXHAUSTED, None, 0, 1), scenario, pole)
    assert unplanned.swept_collision is None
    rates = SafetyRates.of([record, clear, unplanned])
    assert (rates.collisions, rates.swept_collisions, rates.swept_collision_rate) == (0, 1, 0.5)
    assert rates.to_json()["swept_collision_rate"] == 0.5
