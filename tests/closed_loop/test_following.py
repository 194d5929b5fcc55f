"""The controller between plans."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.closed_loop.following import follow
from avsec_gym.scenario.planning_scenario import EgoState

STRAIGHT = np.array([[0.6 * k, 0.0, 6.0, 0.0, 0.0] for k in range(11)])


def test_where_the_car_is_right_the_plan_is_fed_forward() -> None:
    plan = np.array([[0.0, 0.0, 6.0, 0.0, 0.0], [0.62, 0.0, 6.4, 0.0, 0.03]])
    acceleration, steering = follow(plan, 0.0, EgoState(velocity=6.0))
    assert acceleration == pytest.approx(4.0)
    assert steering == pytest.approx(0.03)


def test_deviations_are_steered_and_braked_away() -> None:
    acceleration, steering = follow(STRAIGHT, 0.0, EgoState(x=0.5, y=0.4, velocity=6.5))
    assert acceleration < 0.0
    assert steering < 0.0
    assert follow(STRAIGHT, 0.0, EgoState(velocity=6.0, heading=-0.2))[1] > 0.0


def test_behind_its_end_a_plan_goes_on_straight() -> None:
    beyond = EgoState(x=0.6 * 12, velocity=6.0)
    np.testing.assert_allclose(follow(STRAIGHT, 1.2, beyond), (0.0, 0.0), atol=1e-9)
