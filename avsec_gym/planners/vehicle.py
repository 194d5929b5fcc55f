"""The kinematic single-track vehicle model and the BMW 320i that the thesis drives.

State: rear-axle position x, y (m), velocity v (m/s), heading psi (rad), steering angle delta (rad).
Inputs: longitudinal acceleration a (m/s2) and steering rate (rad/s).

    x' = v cos psi    y' = v sin psi    v' = a    psi' = v tan(delta) / (lf + lr)    delta' = rate

Source: Althoff, Koschi and Manzinger, "CommonRoad: Composable benchmarks for motion planning on
roads", IV 2017, and the vehicle models published with it (vehicle 2).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from avsec_gym.geometry import Floats


@dataclass(frozen=True)
class Vehicle:
    """Size and limits of a vehicle (SI units)."""

    name: str
    length: float
    width: float
    front_axle: float
    """Distance from the centre of gravity to the front axle (CommonRoad's a)."""
    rear_axle: float
    """Distance from the centre of gravity to the rear axle (CommonRoad's b)."""
    max_steering_angle: float
    max_steering_rate: float
    max_acceleration: float
    """Radius of the friction circle."""
    switching_velocity: float
    """The velocity above which the engine's power limits the acceleration to a_max v_switch / v."""
    min_velocity: float
    max_velocity: float

    @property
    def wheelbase(self) -> float:
        """Distance between the axles."""
        return self.front_axle + self.rear_axle


BMW_320I = Vehicle(
    name="BMW_320i",
    length=4.508,
    width=1.610,
    front_axle=1.1561957064,
    rear_axle=1.4227170936,
    max_steering_angle=1.066,
    max_steering_rate=0.4,
    max_acceleration=11.5,
    switching_velocity=7.319,
    min_velocity=-13.9,
    max_velocity=50.8,
)


def simulate(
    vehicle: Vehicle,
    start: Floats,
    acceleration: Floats,
    steering_rate: Floats,
    steps: int,
    dt: float,
    substeps: int = 20,
) -> Floats:
    """Drive with constant inputs (fourth-order Runge-Kutta).

    Args:
        vehicle: The vehicle, whose wheelbase enters.
        start: State x, y, velocity, heading, steering angle at the rear axle, shape (..., 5).
        acceleration: Accelerations, m/s2, shape (...).
        steering_rate: Steering rates, rad/s, shape (...).
        steps: Number of time steps.
        dt: Length of a time step, seconds.
        substeps: Integration steps in each time step.

    Returns:
        States, shape (..., steps + 1, 5), the start first.
    """
    acceleration, steering_rate = np.asarray(acceleration), np.asarray(steering_rate)

    def derivative(state: Floats) -> Floats:
        velocity, heading, steering = state[..., 2], state[..., 3], state[..., 4]
        return np.stack(
            [
                velocity * np.cos(heading),
                velocity * np.sin(heading),
                np.broadcast_to(acceleration, velocity.shape),
                velocity * np.tan(steering) / vehicle.wheelbase,
                np.broadcast_to(steering_rate, velocity.shape),
            ],
            axis=-1,
        )

    state, h = np.asarray(start, float), dt / substeps
    states = [state]
    for _ in range(steps):
        for _ in range(substeps):
            k1 = derivative(state)
            k2 = derivative(state + h / 2 * k1)
            k3 = derivative(state + h / 2 * k2)
            k4 = derivative(state + h * k3)
            state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        states.append(state)
    return np.stack(states, axis=-2)


def is_feasible(
    vehicle: Vehicle, states: Floats, acceleration: Floats, steering_rate: Floats
) -> np.ndarray:
    """Whether driven states keep the vehicle's limits.

    The limits: steering angle and rate, speed range, engine power, and the friction circle
    ``a^2 + (v psi')^2 <= a_max^2`` at every state.

    Args:
        vehicle: The vehicle, whose limits hold.
        states: States of the trajectories, shape (..., T, 5).
        acceleration: Accelerations, m/s2, shape (...).
        steering_rate: Steering rates, rad/s, shape (...).

    Returns:
        Shape (...), bool.
    """
    small = 1e-9
    velocity, steering = states[..., 2], states[..., 4]
    lateral = velocity**2 * np.tan(steering) / vehicle.wheelbase
    a = np.asarray(acceleration)[..., None]
    power = vehicle.max_acceleration * np.where(
        velocity > vehicle.switching_velocity,
        vehicle.switching_velocity / np.maximum(velocity, small),
        1.0,
    )
    return (
        (np.abs(steering) <= vehicle.max_steering_angle + small).all(-1)
        & (np.abs(steering_rate) <= vehicle.max_steering_rate + small)
        & (velocity >= vehicle.min_velocity - small).all(-1)
        & (velocity <= vehicle.max_velocity + small).all(-1)
        & (a <= power + small).all(-1)
        & (a >= -vehicle.max_acceleration - small).all(-1)
        & (a**2 + lateral**2 <= vehicle.max_acceleration**2 + small).all(-1)
    )
