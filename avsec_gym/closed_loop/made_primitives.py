"""Motion primitives for states that the thesis' grids of speeds do not know."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from avsec_gym.closed_loop.integration import driven
from avsec_gym.geometry import Floats
from avsec_gym.planners.primitives import MotionPrimitives
from avsec_gym.planners.vehicle import BMW_320I, is_feasible
from avsec_gym.scenario.planning_scenario import EgoState

_SPACING = 2.0
"""m/s between the speeds of a grid: 4 m/s2 over a primitive."""
_STEPS, _DT = 5, 0.1
"""Time steps of a primitive, and seconds of each."""
_ANGLES = (0.03, 0.07, 0.178, 0.355, 0.533)
"""Steering angles to either side, rad: the thesis' first three, and finer ones for gentle bends."""
_SPEED_GRAIN, _ANGLE_GRAIN = 0.05, 0.015
"""m/s and rad to which a state that was reached is rounded; the following controller evens it out.

The search lets primitives begin where speed and angle lie within 0.01 of the start's."""


def primitives_from(
    velocity: float, steering_angle: float, cruise: tuple[float, float]
) -> MotionPrimitives:
    """Primitives that begin at a state, and a grid of speeds from standing to cruising.

    Args:
        velocity: Speed that was reached, m/s.
        steering_angle: Angle of the wheels that was reached, rad.
        cruise: Least and highest speed that the car wants to drive at, m/s.
    """
    low, high = cruise
    grid = np.arange(low, -1e-9, -_SPACING)
    speeds = sorted(
        {0.0, *np.round(grid, 6).tolist(), *np.arange(low, high + 1e-9, _SPACING).tolist()}
    )
    angles = sorted({0.0, *_ANGLES, *(-angle for angle in _ANGLES)})
    start = (
        _nearest(velocity, speeds, _SPEED_GRAIN),
        _nearest(steering_angle, angles, _ANGLE_GRAIN),
    )
    return _made(start, tuple(speeds), tuple(angles))


def rounded_start(start: EgoState, primitives: MotionPrimitives) -> EgoState:
    """The start with the speed and the angle of the wheels that primitives begin with.

    Args:
        start: The state that was reached.
        primitives: What `primitives_from` made for it.
    """
    begins = primitives.states[:, 0]
    off = abs(begins[:, 2] - start.velocity) + abs(begins[:, 4] - start.steering_angle)
    nearest = begins[int(np.argmin(off))]
    return replace(start, velocity=max(float(nearest[2]), 0.0), steering_angle=float(nearest[4]))


def _nearest(value: float, grid: list[float], grain: float) -> float:
    """The grid's value where it is as good as met, else the value rounded."""
    nearest = min(grid, key=lambda known: abs(known - value))
    if abs(nearest - value) < 0.5 * grain:
        return nearest
    return round(round(value / grain) * grain, 6)


@lru_cache(maxsize=128)
def _made(
    start: tuple[float, float], speeds: tuple[float, ...], angles: tuple[float, ...]
) -> MotionPrimitives:
    grid = _grid(speeds, angles)
    if start[0] in speeds and start[1] in angles:
        return grid
    # What joins the points of the grid is the same for every start; the start's own come last.
    own = _between([start], speeds, angles)
    states = np.concatenate([grid.states, own])
    return replace(grid, states=states, steps=np.full(len(states), _STEPS), grid=grid)


@lru_cache(maxsize=64)
def _grid(speeds: tuple[float, ...], angles: tuple[float, ...]) -> MotionPrimitives:
    states = _between([(v, a) for v in speeds for a in angles], speeds, angles)
    name = f"{BMW_320I.name} 0..{speeds[-1]:g} m/s"
    return MotionPrimitives(states, np.full(len(states), _STEPS), BMW_320I, _DT, name)


def _between(
    starts: list[tuple[float, float]], speeds: tuple[float, ...], angles: tuple[float, ...]
) -> Floats:
    """States of every feasible primitive from some starts onto the grid, shape (P, T + 1, 5)."""
    duration = _STEPS * _DT
    pairs = [
        (start, (v, a))
        for start in starts
        for v in speeds
        for a in angles
        if abs(v - start[0]) <= BMW_320I.max_acceleration * duration
        and abs(a - start[1]) <= BMW_320I.max_steering_rate * duration
    ]
    begin, end = (np.array([pair[side] for pair in pairs]).reshape(-1, 2) for side in (0, 1))
    acceleration = (end[:, 0] - begin[:, 0]) / duration
    steering_rate = (end[:, 1] - begin[:, 1]) / duration
    state = np.zeros((len(pairs), 5))
    state[:, 2], state[:, 4] = begin.T
    states = np.asarray(driven(state, acceleration, steering_rate, _STEPS, _DT))
    states[:, -1, 2], states[:, -1, 4] = end.T
    feasible = is_feasible(BMW_320I, states, acceleration, steering_rate)
    return np.asarray(states[feasible])
