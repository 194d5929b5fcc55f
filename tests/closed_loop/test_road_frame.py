"""The conversion between the two planes."""

from __future__ import annotations

import numpy as np
from highway_env.vehicle.kinematics import Vehicle

from avsec_gym.closed_loop.road_frame import mirrored_angle, mirrored_points


def test_it_is_its_own_inverse() -> None:
    points = np.array([[3.0, -2.0], [0.0, 1.0]])
    np.testing.assert_array_equal(mirrored_points(mirrored_points(points)), points)
    assert mirrored_angle(mirrored_angle(0.4)) == 0.4


def test_what_turns_left_here_turns_left_there() -> None:
    """A car of highway-env that steers by a mirrored angle comes to the mirrored side."""
    car = Vehicle(None, mirrored_points([0.0, 0.0]), mirrored_angle(0.0), 5.0)
    car.act({"steering": mirrored_angle(0.2), "acceleration": 0.0})
    for _ in range(20):
        car.step(0.05)
    x, y = mirrored_points(car.position)
    assert x > 4.0
    assert y > 0.3
    assert mirrored_angle(car.heading) > 0.1
