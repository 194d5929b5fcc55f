"""Plans after which the car can still stop."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
import shapely

from avsec_gym.closed_loop.belief import Belief
from avsec_gym.closed_loop.fail_safe import (
    MARGIN,
    OTHERS_BRAKE,
    _interpolated,
    _jump,
    braked,
    is_fail_safe,
    others_brake,
    steps_to_rest,
)
from avsec_gym.closed_loop.following import follow
from avsec_gym.closed_loop.vehicles import Car
from avsec_gym.planners.vehicle import BMW_320I
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.planning_scenario import EgoState

SPEED = 8.0
PLAN = np.array([[0.1 * SPEED * k, 0.0, SPEED, 0.0, 0.0] for k in range(20)])
"""Straight on at 8 m/s: 4 m until the next replanning, and 4 m of braking."""


def car_at(x: float, speed: float = 0.0) -> Obstacles:
    return Obstacles.rectangles(
        np.array([[x, 0.0, 0.0]]), np.array([4.0]), np.array([2.0]), np.array([speed]), last_step=30
    )


def test_braking_takes_half_of_v_squared_by_a_along_the_path() -> None:
    angle = np.linspace(0.0, 1.0, 101)
    bend = np.column_stack(
        [30 * np.sin(angle), 30 * (1 - np.cos(angle)), np.full(101, SPEED), angle, np.zeros(101)]
    )
    stop = braked(bend, 0.0, SPEED)
    assert stop[-1, 2] == 0.0
    assert stop[-1, 3] * 30 == pytest.approx(SPEED**2 / 16, abs=0.01)
    assert np.hypot(stop[-1, 0], stop[-1, 1] - 30) == pytest.approx(30.0, abs=0.01)


def test_beyond_its_end_a_path_goes_on_straight() -> None:
    assert braked(PLAN[:1], 0.0, SPEED)[-1, 0] == pytest.approx(SPEED**2 / 16)


def test_a_stop_that_goes_beyond_a_bend_can_be_driven() -> None:
    """The car, which begins with turned wheels, comes to rest where the stop does."""
    bent = np.array([[0.0, 0.0, 12.0, 0.0, 0.15]])
    stop = braked(bent, 0.0, 12.0)
    car = Car(None, [0.0, 0.0], 0.0, 12.0)
    car.steering_angle = -0.15
    for step in range(len(stop)):
        state = EgoState(
            car.position[0], -car.position[1], car.speed, -car.heading, -car.steering_angle
        )
        acceleration, steering = follow(stop, 0.1 * step, state)
        car.act({"steering": -steering, "acceleration": acceleration})
        for _ in range(2):
            car.step(0.05)
    assert car.speed < 0.2
    np.testing.assert_allclose((car.position[0], -car.position[1]), stop[-1, :2], atol=0.25)


@pytest.mark.parametrize(("room", "safe"), [(8.1, True), (7.9, False)])
def test_a_plan_holds_where_the_car_can_stop_after_it(room: float, safe: bool) -> None:
    standing = car_at(0.5 * BMW_320I.length + room + 2.0)
    assert is_fail_safe(PLAN, standing, 0.5) == safe


def test_a_stop_beside_the_road_is_none() -> None:
    nothing = Obstacles.none()
    assert is_fail_safe(PLAN, nothing, 0.5, shapely.box(-1.0, -2.0, 8.1, 2.0))
    assert not is_fail_safe(PLAN, nothing, 0.5, shapely.box(-1.0, -2.0, 7.9, 2.0))


def test_what_drives_away_or_comes_from_behind_is_no_hindrance() -> None:
    assert is_fail_safe(PLAN, car_at(7.0, SPEED), 0.5)
    assert is_fail_safe(PLAN, car_at(-8.0, 20.0), 0.5)


def test_what_drives_ahead_may_brake() -> None:
    """At equal speeds a gap that holds while the other drives on does not where it brakes."""
    near = car_at(7.0, SPEED)
    slower = others_brake(near, 0.0)
    assert slower is not None
    assert slower.poses[0, -1, 0] - near.poses[0, 0, 0] <= SPEED**2 / (2 * OTHERS_BRAKE) + 1e-9
    assert others_brake(car_at(7.0), 0.0) is None
    assert not is_fail_safe(PLAN, car_at(5.0, SPEED), 0.5)


@pytest.mark.parametrize(("speed", "room"), [(0.0, 0.02), (0.3, 0.02 + MARGIN)])
def test_what_moves_is_given_a_margin(speed: float, room: float) -> None:
    """A car that came to rest in between, 5 cm from where it was believed to be, was grazed."""
    aside = 0.5 * BMW_320I.width + 1.0
    for off, safe in ((aside + room, True), (aside + room - 0.04, False)):
        beside = Obstacles.rectangles(
            np.array([[6.0, off, 0.0]]),
            np.array([4.0]),
            np.array([2.0]),
            np.array([speed]),
            last_step=30,
        )
        assert is_fail_safe(PLAN, beside, 0.5) == safe


def test_who_brakes_keeps_to_the_way_that_it_is_believed_to_take() -> None:
    """On a circle of 30 m, after v t - a t^2 / 2 of it."""
    time = 0.1 * np.arange(31)
    angle = SPEED * time / 30
    poses = np.column_stack([30 * np.sin(angle), 30 * (1 - np.cos(angle)), angle])
    bent = replace(car_at(0.0, SPEED), poses=poses[None])
    slower = others_brake(bent, 0.0)
    assert slower is not None
    braking = np.minimum(time, SPEED / OTHERS_BRAKE)
    along = (SPEED * braking - OTHERS_BRAKE * braking**2 / 2) / 30
    expected = np.column_stack([30 * np.sin(along), 30 * (1 - np.cos(along)), along])
    np.testing.assert_allclose(slower.poses[0], expected, atol=0.005)


@pytest.mark.parametrize(("gap", "safe"), [(0.5, False), (2.5, True)])
def test_a_stop_does_not_end_just_before_what_comes(gap: float, safe: bool) -> None:
    """The car comes to rest after 1.5 s, and 0.5 m are driven in less than a time step."""
    oncoming = 10.0
    front = 8.0 + 0.5 * BMW_320I.length  # 4 m until the next replanning, 4 m of braking.
    x = front + MARGIN + gap + 2.0 + oncoming * 1.5
    comes = Obstacles.rectangles(
        np.array([[x, 0.0, np.pi]]), np.array([4.0]), np.array([2.0]), np.array([oncoming]),
        last_step=30,
    )  # fmt: skip
    assert is_fail_safe(PLAN, comes, 0.5) == safe


@pytest.mark.parametrize(("gap", "safe"), [(100.0, False), (101.0, False), (102.0, True)])
def test_at_high_speed_what_comes_moves_until_the_car_has_come_to_rest(
    gap: float, safe: bool
) -> None:
    """Both drive at 20 m/s: 10 m and 25 m of braking here, 62 m in 3.1 s there, and the lengths."""
    speed = 20.0
    plan = np.array([[0.1 * speed * k, 0.0, speed, 0.0, 0.0] for k in range(20)])
    size = np.array([4.0]), np.array([2.0])
    comes = Belief(
        0.0, np.array([[gap, 0.0, np.pi]]), *size, np.array([speed]), RoadType.HIGHWAY
    ).obstacles(last_step=steps_to_rest(speed, 0.5))
    assert is_fail_safe(plan, comes, 0.5) == safe


@pytest.mark.parametrize("speed", [0.0, 8.0, 19.2, 19.3, 30.0])
@pytest.mark.parametrize("acceleration", [-8.0, 0.0, BMW_320I.max_acceleration])
@pytest.mark.parametrize("until", [0.1, 0.5, 2.0])
def test_no_plan_takes_more_steps_to_rest(speed: float, acceleration: float, until: float) -> None:
    last = round(until / 0.1)
    reached = max(speed + acceleration * until, 0.0)
    plan = np.zeros((last + 1, 5))
    plan[:, 2] = np.linspace(speed, reached, last + 1)
    braking = len(braked(plan, until, reached)) - 1
    assert last + braking + 1 <= steps_to_rest(speed, until)


def test_interpolation_is_numpys_bit_for_bit() -> None:
    draw = np.random.default_rng(3)
    for _ in range(200):
        steps = np.where(draw.random(9) < 0.2, 0.0, draw.uniform(0, 2, 9))
        places, values = np.cumsum(steps), draw.normal(size=9)
        for place in (*draw.uniform(-1, places[-1] + 1, 9), *places):
            assert _interpolated(place, places, values) == np.interp(place, places, values)


def test_headings_are_unwrapped_as_numpy_does() -> None:
    for headings in (np.random.default_rng(4).uniform(-7, 7, 40), np.array([0, np.pi, 0, -np.pi])):
        jumps = [_jump(*pair) for pair in itertools.pairwise(headings)]
        np.testing.assert_allclose(
            headings[1:] + np.cumsum(jumps), np.unwrap(headings)[1:], atol=1e-12
        )
