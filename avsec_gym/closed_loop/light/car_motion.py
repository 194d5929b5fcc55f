"""The car's motion and touch as kernels: `Car` of highway-env's plane, mirrored, bit for bit."""

from __future__ import annotations

import numpy as np

from avsec_gym.closed_loop.vehicles import MOST_ACCELERATION, RESPONSE
from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel
from avsec_gym.planners.vehicle import BMW_320I

X, Y, SPEED, HEADING, STEERING = range(5)
"""Columns of a car's state: x, y of the centre (m), m/s, radians to the left."""
LENGTH, WIDTH = BMW_320I.length, BMW_320I.width
_OFFSET, _BASE = BMW_320I.rear_axle, BMW_320I.wheelbase
_MOST_ANGLE, _MOST_RATE = BMW_320I.max_steering_angle, BMW_320I.max_steering_rate


@kernel(nogil=True)
def steering_rate(state: Floats, wanted: float) -> float:
    """How fast the wheels turn towards an angle, rad/s, as `Car.act` has it."""
    rate = (_within(wanted, _MOST_ANGLE) - state[STEERING]) / RESPONSE
    return _within(rate, _MOST_RATE)


@kernel(nogil=True)
def drive_on(
    state: Floats, acceleration: float, wanted: float, rate: float, dt: float, after: Floats
) -> None:
    """`Car.step`: the kinematic single-track model by fourth-order Runge-Kutta.

    Args:
        state: The car's state, shape (5,).
        acceleration: The car's acceleration, m/s2.
        wanted: The angle that the wheels turn to, rad.
        rate: How fast they turn, rad/s.
        dt: Length of the step, seconds.
        after: Memory for the state that is reached, shape (5,).
    """
    acceleration, wanted = _within(acceleration, MOST_ACCELERATION), _within(wanted, _MOST_ANGLE)
    v, heading, steering = state[SPEED], state[HEADING], state[STEERING]
    turned = rate * dt
    if abs(turned) > abs(wanted - steering):
        turned = wanted - steering
    # Time until the car stands, if that comes first.
    h = dt
    if acceleration < 0.0:
        h = min(dt, v / -acceleration)
    turn = turned / dt
    x, y = state[X] - _OFFSET * np.cos(heading), state[Y] - _OFFSET * np.sin(heading)
    # Speed and wheels are known at every time; heading and place follow from them.
    middle, end = v + acceleration * h / 2, v + acceleration * h
    turn_1 = v * np.tan(steering) / _BASE
    turn_2 = middle * np.tan(steering + turn * h / 2) / _BASE
    turn_4 = end * np.tan(steering + turn * h) / _BASE
    heading_2, heading_3 = heading + h / 2 * turn_1, heading + h / 2 * turn_2
    heading_4 = heading + h * turn_2
    # One after the other, as `Car` adds them: sums in another order would be rounded otherwise.
    # Invariant: x and y hold the start and the parts so far.
    for part, weight, angle in (
        (v, 1 / 6, heading),
        (middle, 1 / 3, heading_2),
        (middle, 1 / 3, heading_3),
        (end, 1 / 6, heading_4),
    ):
        x += h * weight * part * np.cos(angle)
        y += h * weight * part * np.sin(angle)
    heading += h / 6 * (turn_1 + 4 * turn_2 + turn_4)
    after[X], after[Y] = x + _OFFSET * np.cos(heading), y + _OFFSET * np.sin(heading)
    after[HEADING] = heading
    after[SPEED] = end if h == dt and end >= 0.0 else 0.0
    # Wheels turn on while the car stands.
    after[STEERING] = steering + turn * h + turned * (1.0 - h / dt)


@kernel(nogil=True)
def touches(car: Floats, pose: Floats, size: Floats) -> bool:
    """Whether the car and an actor's rectangle have a point in common, by separating axes.

    Args:
        car: The car's state, shape (5,).
        pose: The actor's x, y, heading, shape (3,).
        size: The actor's length and width, metres, shape (2,).
    """
    dx, dy = pose[0] - car[X], pose[1] - car[Y]
    half_length, half_width = 0.5 * size[0], 0.5 * size[1]
    reach = np.hypot(half_length, half_width) + np.hypot(0.5 * LENGTH, 0.5 * WIDTH)
    if dx * dx + dy * dy > reach * reach:
        return False
    cos, sin = np.cos(car[HEADING]), np.sin(car[HEADING])
    other_cos, other_sin = np.cos(pose[2]), np.sin(pose[2])
    # Cosine and sine of the angle between the two are the shares of one's axes on the other's.
    across = abs(cos * other_sin - sin * other_cos)
    along = abs(cos * other_cos + sin * other_sin)
    return bool(
        abs(cos * dx + sin * dy) <= 0.5 * LENGTH + half_length * along + half_width * across
        and abs(cos * dy - sin * dx) <= 0.5 * WIDTH + half_length * across + half_width * along
        and abs(other_cos * dx + other_sin * dy)
        <= half_length + 0.5 * LENGTH * along + 0.5 * WIDTH * across
        and abs(other_cos * dy - other_sin * dx)
        <= half_width + 0.5 * LENGTH * across + 0.5 * WIDTH * along
    )


@kernel(nogil=True)
def _within(value: float, most: float) -> float:
    return float(min(max(value, -most), most))
