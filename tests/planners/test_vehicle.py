"""The kinematic single-track model against numerical integration and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from avsec_gym.planners.vehicle import BMW_320I, is_feasible, simulate


def test_parameters_are_commonroads_vehicle_2() -> None:
    package = pytest.importorskip("vehiclemodels.parameters_vehicle2")
    p = package.parameters_vehicle2()
    assert (BMW_320I.length, BMW_320I.width) == pytest.approx((p.l, p.w))
    assert (BMW_320I.front_axle, BMW_320I.rear_axle) == pytest.approx((p.a, p.b))
    assert BMW_320I.max_steering_angle == pytest.approx(p.steering.max)
    assert BMW_320I.max_steering_rate == pytest.approx(p.steering.v_max)
    assert BMW_320I.max_acceleration == pytest.approx(p.longitudinal.a_max)
    assert BMW_320I.switching_velocity == pytest.approx(p.longitudinal.v_switch)
    assert (BMW_320I.min_velocity, BMW_320I.max_velocity) == pytest.approx(
        (p.longitudinal.v_min, p.longitudinal.v_max)
    )


@settings(max_examples=25)
@given(
    st.floats(1, 20), st.floats(-0.8, 0.8), st.floats(-6, 6), st.floats(-0.4, 0.4), st.floats(-3, 3)
)
def test_simulation_agrees_with_an_adaptive_integrator(
    velocity: float, steering: float, acceleration: float, rate: float, heading: float
) -> None:
    def derivative(_: float, state: np.ndarray) -> list[float]:
        _, _, v, psi, delta = state
        return [
            v * np.cos(psi),
            v * np.sin(psi),
            acceleration,
            v * np.tan(delta) / (1.1561957064 + 1.4227170936),
            rate,
        ]

    start = np.array([1.0, -2.0, velocity, heading, steering])
    ours = simulate(BMW_320I, start, np.array(acceleration), np.array(rate), 5, 0.1)
    theirs = solve_ivp(
        derivative, (0, 0.5), start, t_eval=np.linspace(0, 0.5, 6), rtol=1e-10, atol=1e-10
    )
    np.testing.assert_allclose(ours, theirs.y.T, atol=1e-6)


def test_braking_car_stops_after_v_squared_over_2a() -> None:
    start = np.array([0.0, 0, 10, 0, 0])
    states = simulate(BMW_320I, start, np.array(-5.0), np.array(0.0), 20, 0.1)
    assert states[-1, 2] == pytest.approx(0.0, abs=1e-9)
    assert states[-1, 0] == pytest.approx(10**2 / (2 * 5))
    assert np.abs(states[:, [1, 3]]).max() == 0.0


def test_constant_steering_drives_a_circle() -> None:
    steering, velocity = 0.3, 5.0
    radius = BMW_320I.wheelbase / np.tan(steering)
    start = np.array([0.0, 0, velocity, 0, steering])
    states = simulate(BMW_320I, start, np.array(0.0), np.array(0.0), 60, 0.1)
    np.testing.assert_allclose(np.hypot(states[:, 0], states[:, 1] - radius), radius, rtol=1e-7)
    np.testing.assert_allclose(states[:, 3], velocity / radius * 0.1 * np.arange(61), atol=1e-9)


def test_a_batch_is_its_members() -> None:
    starts = np.array([[0.0, 0, 6, 0, 0.1], [1, 1, 8, 1, -0.2]])
    a, rate = np.array([1.0, -2.0]), np.array([0.2, -0.1])
    together = simulate(BMW_320I, starts, a, rate, 5, 0.1)
    for i in range(2):
        np.testing.assert_array_equal(
            together[i], simulate(BMW_320I, starts[i], a[i], rate[i], 5, 0.1)
        )


@pytest.mark.parametrize(
    ("velocity", "steering", "acceleration", "rate", "feasible"),
    [
        (6.0, 0.0, 0.0, 0.0, True),
        (6.0, 1.07, 0.0, 0.0, False),
        (6.0, 0.0, 0.0, 0.41, False),
        (51.0, 0.0, 0.0, 0.0, False),
        (7.0, 0.0, 11.5, 0.0, True),
        (14.638, 0.0, 5.76, 0.0, False),  # twice the switching velocity: half the acceleration
        (14.638, 0.0, 5.74, 0.0, True),
        (14.638, 0.0, -11.5, 0.0, True),
        (10.0, 0.2877, 0.0, 0.0, True),  # 10^2 tan(0.2877) / 2.579 = 11.47
        (10.0, 0.289, 0.0, 0.0, False),
        (10.0, 0.2, 8.4, 0.0, False),  # 8.4^2 + 7.86^2 > 11.5^2, though each is below
    ],
)
def test_limits(
    velocity: float, steering: float, acceleration: float, rate: float, feasible: bool
) -> None:
    states = np.array([[0.0, 0, velocity, 0, steering]])
    assert bool(is_feasible(BMW_320I, states, np.array(acceleration), np.array(rate))) == feasible
