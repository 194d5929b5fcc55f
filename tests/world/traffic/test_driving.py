import numpy as np
import pytest

from avsec_gym.world.traffic.driving import (
    LATERAL_ACCELERATION,
    Manners,
    bend_limits,
    calm_interaction,
    equilibrium_gap,
    idm_acceleration,
    idm_interaction,
)

MANNERS = Manners(*(np.array(each) for each in (1.3, 2.0, 1.4, 2.0)))


def test_in_equilibrium_no_driver_accelerates() -> None:
    for speed in (3.0, 8.0, 13.0):
        gap = float(equilibrium_gap(speed, 15.0, MANNERS))
        felt = idm_interaction(speed, gap, 0.0, *map(float, MANNERS))
        assert idm_acceleration(speed, 15.0, felt, MANNERS) == pytest.approx(0.0, abs=1e-9)


def test_a_free_driver_speeds_up_to_the_desired_speed() -> None:
    assert idm_acceleration(0.0, 15.0, 0.0, MANNERS) == pytest.approx(1.4)
    assert idm_acceleration(15.0, 15.0, 0.0, MANNERS) == pytest.approx(0.0)
    assert idm_acceleration(20.0, 15.0, 0.0, MANNERS) < 0


def test_calm_drivers_brake_enough_and_not_in_panic() -> None:
    """20 m/s towards an obstacle 50 m away takes 4 m/s2; the calm driver brakes more."""
    arguments = (20.0, 50.0, 20.0, 1.3, 2.0, 1.4, 2.0)
    assert 1.4 * calm_interaction(*arguments) >= 4.0
    slower = (33.0, 60.0, 9.0, 1.3, 2.0, 1.4, 2.0)
    assert 1.4 * calm_interaction(*slower) < 4.0 < 1.4 * idm_interaction(*slower)


def test_speeds_for_a_bend_are_reached_by_comfortable_braking() -> None:
    curvature = np.zeros(400)
    curvature[300:340] = 1 / 20
    limit = bend_limits(curvature, 0.5)
    assert limit[300:340] == pytest.approx(np.sqrt(LATERAL_ACCELERATION * 20))
    braking = -0.5 * np.diff(limit**2) / 0.5
    assert braking.max() < 1.3
    assert (limit[340:] > 100).all()
