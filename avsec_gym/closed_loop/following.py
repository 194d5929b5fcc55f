"""The controller between plans: it drives along a planned trajectory, and evens out deviations."""

from __future__ import annotations

import math

import numpy as np

from avsec_gym.geometry import Floats, wrap_angle
from avsec_gym.scenario.planning_scenario import EgoState

_ALONG, _SPEED = 1.0, 2.0
"""Acceleration for a metre behind and for a m/s too slow."""
_ASIDE, _TURNED = 0.15, 0.8
"""Steering angle for a metre too far to the left, and for a radian turned too far to the left."""


def follow(
    trajectory: Floats, elapsed: float, state: EgoState, dt: float = 0.1
) -> tuple[float, float]:
    """Acceleration and steering angle that keep a car on a trajectory.

    Both are fed forward from the trajectory, so that a car that is where it should be drives the
    plan as it was planned; what it is off by is fed back.

    Args:
        trajectory: States x, y of the centre, velocity, heading, steering angle at every `dt`,
            shape (T, 5).
        elapsed: Time since the trajectory's first state, seconds.
        state: Where the car is.
        dt: Length of a time step, seconds.

    Returns:
        Acceleration, m/s2, and the angle to turn the wheels to until the next step, rad, positive
        to the left.  Behind its end, the trajectory goes on straight at its last speed.
    """
    now, then = _at(trajectory, elapsed, dt), _at(trajectory, elapsed + dt, dt)
    cos, sin = math.cos(now[3]), math.sin(now[3])
    ahead = cos * (state.x - now[0]) + sin * (state.y - now[1])
    left = cos * (state.y - now[1]) - sin * (state.x - now[0])
    turned = float(wrap_angle(state.heading - now[3]))
    acceleration = (then[2] - now[2]) / dt - _ALONG * ahead - _SPEED * (state.velocity - now[2])
    return acceleration, then[4] - _ASIDE * left - _TURNED * turned


def _at(trajectory: Floats, time: float, dt: float) -> list[float]:
    """The state at a time, linear between time steps."""
    last = len(trajectory) - 1
    step = min(time / dt, float(last))
    before = min(int(step + 1e-9), last)
    after = min(before + 1, last)
    share = max(step - before, 0.0)
    state = trajectory[before] + share * (trajectory[after] - trajectory[before])
    beyond = max(time - last * dt, 0.0)
    if beyond > 1e-9:
        way = beyond * float(state[2])
        state = state + np.array([way * math.cos(state[3]), way * math.sin(state[3]), 0, 0, 0])
        state[4] = 0.0
    return [float(value) for value in state]
