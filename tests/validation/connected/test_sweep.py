"""A turn's times and the vehicle's motion meanwhile."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from avsec_gym.errors import ConfigurationError
from avsec_gym.validation.connected.sweep import (
    TIP,
    RollingSweep,
    from_scan_time,
    ray_time,
    through,
    to_scan_time,
    when_faced,
)

_COORDINATE = st.floats(-80, 80)
_SWEEPS = [(14.0, 0.6, 0.1), (-9.0, -0.4, 0.13), (30.0, 0.0, 0.1), (0.0, 0.9, 0.2), (5.0, 0.3, 0.0)]
"""Speed, turn rate, period."""
_PLACES = [(6.0, 3.5, 0.8), (-7.5, 2.5, -1.2), (-4.0, -9.0, 0.3), (11.0, -2.0, 1.9)]


def _after(seconds: float, speed: float, turn_rate: float) -> tuple[complex, complex]:
    """Where a vehicle is that drives on a circle, and where it heads; x + iy."""
    heading = np.exp(1j * turn_rate * seconds)
    if turn_rate == 0.0:
        return complex(speed * seconds), heading
    radius = speed / turn_rate
    return 1j * radius * (1.0 - heading), heading


def _faced(place: complex, period: float) -> float:
    return float(np.angle(place)) * period / (2 * np.pi)


def _is(x: float, y: float) -> object:
    return pytest.approx((x, y), abs=1e-9)


def test_a_wall_seen_late_on_the_left_lies_behind_where_the_vehicle_sees_it() -> None:
    # Left after a quarter of a turn of 0.1 s, at 20 m/s: half a metre on.
    points = np.array([[0.0, 10.0, 1.0, 0.5]], np.float32)
    places, seconds = RollingSweep(20.0).compensated(points)
    assert seconds[0] == pytest.approx(0.025)
    assert places[0].tolist() == pytest.approx([0.5, 10.0, 1.0])


def test_a_turn_begins_and_ends_behind() -> None:
    assert ray_time(-1.0, -1e-9, 0.1) == pytest.approx(-0.05)
    assert ray_time(-1.0, 1e-9, 0.1) == pytest.approx(0.05)


@given(
    x=_COORDINATE,
    y=_COORDINATE,
    seconds=st.floats(-0.05, 0.05),
    speed=st.floats(-40, 40),
    turn_rate=st.floats(-1, 1),
)
def test_there_and_back(x: float, y: float, seconds: float, speed: float, turn_rate: float) -> None:
    there = to_scan_time(x, y, seconds, speed, turn_rate)
    assert from_scan_time(*there, seconds, speed, turn_rate) == pytest.approx((x, y), abs=1e-9)


def test_a_circle_closes() -> None:
    # At 1 rad/s and 10 m/s the circle has a radius of 10 m: half of it is 20 m to the left.
    assert to_scan_time(0.0, 0.0, np.pi, 10.0, 1.0) == pytest.approx((0.0, 20.0))


@pytest.mark.parametrize("wrong", [(np.nan, 0.0, 0.1), (0.0, np.inf, 0.1), (0.0, 0.0, -0.1)])
def test_what_is_no_sweep_is_refused(wrong: tuple[float, float, float]) -> None:
    with pytest.raises(ConfigurationError):
        RollingSweep(*wrong)


def test_a_turn_of_a_second_is_the_longest_and_none_the_shortest() -> None:
    assert RollingSweep(period=1.0).period == 1.0
    assert RollingSweep(period=0.0).period == 0.0
    assert RollingSweep() == RollingSweep(0.0, 0.0, 0.1)
    with pytest.raises(ConfigurationError):
        RollingSweep(period=1.01)


def test_rays_leave_from_the_middle_of_the_two_blocks_of_lasers() -> None:
    assert pytest.approx((0.2 + 0.13) / 2) == TIP


@pytest.mark.parametrize("sweep", _SWEEPS)
@pytest.mark.parametrize("seconds", [-0.7, -0.04, 0.0, 0.03, 0.5])
def test_the_vehicle_drives_on_a_circle_meanwhile(
    sweep: tuple[float, float, float], seconds: float
) -> None:
    speed, turn_rate, _ = sweep
    place, heading = _after(seconds, speed, turn_rate)
    for x, y, _ in _PLACES:
        there = place + heading * complex(x, y)
        assert to_scan_time(x, y, seconds, speed, turn_rate) == _is(there.real, there.imag)
        back = (complex(x, y) - place) / heading
        assert from_scan_time(x, y, seconds, speed, turn_rate) == _is(back.real, back.imag)


@pytest.mark.parametrize("sweep", _SWEEPS)
def test_each_point_is_moved_by_what_the_vehicle_did_since_its_own_pulse(
    sweep: tuple[float, float, float],
) -> None:
    speed, turn_rate, period = sweep
    places, seconds = RollingSweep(*sweep).compensated(np.array(_PLACES, np.float32))
    facing = RollingSweep(*sweep).facing_time(*np.array(_PLACES).T[:2])
    for index, (x, y, z) in enumerate(_PLACES):
        time = _faced(complex(x, y), period)
        vehicle, heading = _after(time, speed, turn_rate)
        there = vehicle + heading * complex(x, y)
        assert facing[index] == pytest.approx(time, abs=1e-9)
        # The points are of single precision.
        assert seconds[index] == pytest.approx(time, abs=1e-7)
        assert places[index] == pytest.approx([there.real, there.imag, z], abs=1e-5)


@pytest.mark.parametrize("sweep", _SWEEPS)
def test_what_stands_is_seen_where_the_fourth_look_has_it(
    sweep: tuple[float, float, float],
) -> None:
    speed, turn_rate, period = sweep
    rolled = RollingSweep(*sweep).rolled(np.array(_PLACES))
    for (x, y, z), found in zip(_PLACES, rolled, strict=True):
        seen = complex(x, y)
        for _ in range(4):
            vehicle, heading = _after(_faced(seen, period), speed, turn_rate)
            seen = (complex(x, y) - vehicle) / heading
        assert found == pytest.approx([seen.real, seen.imag, z], abs=1e-9)
    back, _ = RollingSweep(*sweep).compensated(rolled.astype(np.float32))
    assert back == pytest.approx(np.array(_PLACES), abs=2e-3)


def _transform(seed: int) -> np.ndarray:
    """A rigid one of which no number is 0 or 1, but those of the last row."""
    random = np.random.default_rng(seed)
    pose = np.eye(4)
    pose[:3, :3] = Rotation.random(random_state=seed).as_matrix()
    pose[:3, 3] = random.uniform(3, 9, 3)
    return pose


@pytest.mark.parametrize("seed", range(3))
def test_a_place_goes_through_a_transform_as_through_a_matrix(seed: int) -> None:
    pose = _transform(seed)
    for place in _PLACES:
        assert through(pose, *place) == pytest.approx((pose @ [*place, 1.0])[:3], abs=1e-9)


@pytest.mark.parametrize("sweep", _SWEEPS)
@pytest.mark.parametrize("place", _PLACES)
@pytest.mark.parametrize("age", [-0.3, 0.0, 0.45])
def test_what_moves_is_where_the_second_look_has_it(
    sweep: tuple[float, float, float], place: tuple[float, float, float], age: float
) -> None:
    speed, turn_rate, period = sweep
    to_sensor, velocity = _transform(4), np.array([7.0, -4.0])

    def look(time: float, faced: float) -> tuple[complex, float]:
        """From the sensor at one time, the place at another."""
        moved = np.array(place[:2]) + (age + time) * velocity
        x, y, z, _ = to_sensor @ [*moved, place[2], 1.0]
        vehicle, heading = _after(faced, speed, turn_rate)
        return (complex(x, y) - vehicle) / heading, z

    # The first look has it where it is at the scan's time, the second where it is when that
    # faces it; the head's time is of where it is then in the frame of the scan's time.
    later, time, seen, z = 0.0, 0.0, 0j, 0.0
    faced = 0.0
    for _ in range(2):
        later = faced
        time = _faced(look(later, 0.0)[0], period)
        seen, z = look(later, time)
        faced = _faced(seen, period)
    found = when_faced(to_sensor, sweep, age, np.array(place), velocity)
    expected = (seen.real, seen.imag, z, np.angle(seen), age + later, time, abs(faced - time))
    assert found == pytest.approx(expected, abs=1e-9)
    # The true time, at which the head faces it where it is then, is as near as that says.
    true = faced
    for _ in range(60):
        true = 0.5 * (true + _faced(look(true, true)[0], period))
    assert abs(true - time) <= 2.0 * found[6] + 1e-9
