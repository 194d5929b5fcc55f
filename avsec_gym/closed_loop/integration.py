"""`simulate` as a kernel: a driver asks for many short drives, one after the other."""

from __future__ import annotations

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel
from avsec_gym.planners.vehicle import BMW_320I

SUBSTEPS = 4
"""Integration steps in each time step."""
_BASE = BMW_320I.wheelbase


@kernel(nogil=True)
def driven(
    start: Floats, acceleration: Floats, steering_rate: Floats, steps: int, dt: float
) -> Floats:
    """Drive the BMW 320i with constant inputs, by the same Runge-Kutta rule as `simulate`.

    Args:
        start: States x, y, velocity, heading, steering angle at the rear axle, shape (N, 5).
        acceleration: Accelerations, m/s2, shape (N,).
        steering_rate: Rates of the steering angles, rad/s, shape (N,).
        steps: Number of time steps.
        dt: Length of a time step, seconds.

    Returns:
        States, shape (N, steps + 1, 5), the start first.
    """
    states = np.empty((len(start), steps + 1, 5))
    h = dt / SUBSTEPS
    for n in range(len(start)):
        # Value by value: to assign a row, numba compiles the message of an error of shapes, too.
        for column in range(5):
            states[n, 0, column] = start[n, column]
        x, y, v = start[n, 0], start[n, 1], start[n, 2]
        heading, steering = start[n, 3], start[n, 4]
        a, rate = acceleration[n], steering_rate[n]
        for step in range(steps):
            for _ in range(SUBSTEPS):
                # Speed and wheels are known at every time; heading and place follow from them.
                v_2, v_4 = v + h / 2 * a, v + h * a
                turn_1 = v * np.tan(steering) / _BASE
                turn_2 = v_2 * np.tan(steering + h / 2 * rate) / _BASE
                turn_4 = v_4 * np.tan(steering + h * rate) / _BASE
                heading_2, heading_3 = heading + h / 2 * turn_1, heading + h / 2 * turn_2
                heading_4 = heading + h * turn_2
                x += h / 6 * (v * np.cos(heading) + v_4 * np.cos(heading_4))
                x += h / 3 * v_2 * (np.cos(heading_2) + np.cos(heading_3))
                y += h / 6 * (v * np.sin(heading) + v_4 * np.sin(heading_4))
                y += h / 3 * v_2 * (np.sin(heading_2) + np.sin(heading_3))
                heading += h / 6 * (turn_1 + 4 * turn_2 + turn_4)
                v, steering = v_4, steering + h * rate
            states[n, step + 1, 0], states[n, step + 1, 1], states[n, step + 1, 2] = x, y, v
            states[n, step + 1, 3], states[n, step + 1, 4] = heading, steering
    return states
