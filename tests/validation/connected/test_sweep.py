"""A turn's times and the vehicle's motion meanwhile."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from avsec_gym.errors import ConfigurationError
from avsec_gym.validation.connected.sweep import (
    RollingSweep,
    from_scan_time,
    ray_time,
    to_scan_time,
)

_COORDINATE = st.floats(-80, 80)


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
