"""The vehicles of the loop as highway-env drives them: the car, recorded actors, reacting ones."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from highway_env.road.road import Road
from highway_env.vehicle.behavior import IDMVehicle
from highway_env.vehicle.controller import MDPVehicle
from highway_env.vehicle.graphics import VehicleGraphics
from highway_env.vehicle.kinematics import Vehicle

from avsec_gym.closed_loop.road_frame import mirrored_angle, mirrored_points
from avsec_gym.closed_loop.tracks import Tracks
from avsec_gym.geometry import Floats
from avsec_gym.planners.vehicle import BMW_320I

RESPONSE = 0.1
"""Seconds in which the wheels turn to the angle that is asked for, if they are that fast."""
MOST_ACCELERATION = 8.0
"""m/s2: full braking on a dry road, as in an emergency stop."""


class Car(Vehicle):  # type: ignore[misc]
    """The car that is driven: the planner's kinematic single-track model of the BMW 320i.

    It replaces highway-env's modified bicycle, so that a planned trajectory can be driven as it was
    planned.  The wheels turn at a limited rate, the car never rolls backwards, and it stops exactly
    where constant braking brings it to rest.
    """

    LENGTH, WIDTH = BMW_320I.length, BMW_320I.width
    MIN_SPEED = 0.0
    position: Floats
    heading: float
    speed: float
    steering_angle = 0.0
    """Steering angle of the wheels, radians, positive to the right as in highway-env's plane."""
    _rate = 0.0

    @property
    def color(self) -> tuple[int, int, int]:
        """The colour of a driven vehicle in highway-env: green, and red once it has crashed."""
        colour: tuple[int, int, int] = VehicleGraphics.EGO_COLOR
        return VehicleGraphics.RED if self.crashed else colour

    def act(self, action: dict[str, float] | str | None = None) -> None:
        """Take an acceleration (m/s2) and a steering angle (rad, to the right) to turn to."""
        before = self.action
        super().act(action)
        if self.action is not before:
            wanted = _within(self.action["steering"], BMW_320I.max_steering_angle)
            rate = (wanted - self.steering_angle) / RESPONSE
            self._rate = _within(rate, BMW_320I.max_steering_rate)

    def step(self, dt: float) -> None:
        """Drive on for a time, seconds."""
        acceleration = _within(float(self.action["acceleration"]), MOST_ACCELERATION)
        wanted = _within(float(self.action["steering"]), BMW_320I.max_steering_angle)
        turned = self._rate * dt
        if abs(turned) > abs(wanted - self.steering_angle):
            turned = wanted - self.steering_angle
        # Time until the car stands, if that comes first.
        driving = dt
        if acceleration < 0.0:
            driving = min(dt, self.speed / -acceleration)
        self._drive(driving, acceleration, turned / dt)
        self.steering_angle += turned * (1.0 - driving / dt)
        if driving < dt or self.speed < 0.0:
            self.speed = 0.0
        self.on_state_update()

    def _drive(self, duration: float, acceleration: float, rate: float) -> None:
        """Integrate the single-track model (fourth-order Runge-Kutta), about the rear axle."""
        offset, base = BMW_320I.rear_axle, BMW_320I.wheelbase
        v, heading, steering = float(self.speed), float(self.heading), self.steering_angle
        x = float(self.position[0]) - offset * math.cos(heading)
        y = float(self.position[1]) - offset * math.sin(heading)
        h = duration
        # Speed and wheels are known at every time; heading and place follow from them.
        middle, end = v + acceleration * h / 2, v + acceleration * h
        turn_1 = v * math.tan(steering) / base
        turn_2 = middle * math.tan(steering + rate * h / 2) / base
        turn_4 = end * math.tan(steering + rate * h) / base
        heading_2, heading_3 = heading + h / 2 * turn_1, heading + h / 2 * turn_2
        heading_4 = heading + h * turn_2
        for part, weight, angle in (
            (v, 1 / 6, heading),
            (middle, 1 / 3, heading_2),
            (middle, 1 / 3, heading_3),
            (end, 1 / 6, heading_4),
        ):
            x += h * weight * part * math.cos(angle)
            y += h * weight * part * math.sin(angle)
        heading += h / 6 * (turn_1 + 4 * turn_2 + turn_4)
        self.position = np.array([x + offset * math.cos(heading), y + offset * math.sin(heading)])
        self.heading, self.speed = heading, end
        self.steering_angle = steering + rate * h


class CarWithMetaActions(Car, MDPVehicle):  # type: ignore[misc]
    """The same car under highway-env's own controllers: faster, slower, left lane, right lane."""

    def steering_control(self, target_lane_index: Any) -> float:
        """The steering of highway-env, there for a wheelbase as long as the car, for this one."""
        angle = MDPVehicle.steering_control(self, target_lane_index)
        return math.atan(math.tan(angle) * BMW_320I.wheelbase / self.LENGTH)


class _Actor:
    """What recorded and reacting actors share: a size of their own, and an id."""

    def __init__(self, tracks: Tracks, actor: int, road: Road) -> None:
        self.actor = int(tracks.ids[actor])
        self.LENGTH, self.WIDTH = (
            float(tracks.dimensions[actor, 2]),
            float(tracks.dimensions[actor, 1]),
        )


class RecordedVehicle(_Actor, Vehicle):  # type: ignore[misc]
    """An actor that plays its track, whatever happens around it.

    Args:
        tracks: The recorded actors.
        actor: Row of this one.
        road: The road that it is on.
        time: Seconds since the start of the tracks.
    """

    def __init__(self, tracks: Tracks, actor: int, road: Road, time: float = 0.0) -> None:
        _Actor.__init__(self, tracks, actor, road)
        self.tracks, self.row, self._steps, self._dt, self._begun = tracks, actor, 0, 0.0, time
        x, y, heading, speed = tracks.state(actor, time)
        self._lane_index: Any = None
        Vehicle.__init__(self, road, mirrored_points([x, y]), mirrored_angle(heading), speed)
        # Two recorded actors may touch: that is no accident of the car.
        self.check_collisions = False

    @property
    def lane_index(self) -> Any:
        """The nearest lane's index, found when it is asked for: highway-env seldom does."""
        if self._lane_index is None:
            self._lane_index = self.road.network.get_closest_lane_index(self.position, self.heading)
        return self._lane_index

    @lane_index.setter
    def lane_index(self, index: Any) -> None:
        self._lane_index = None

    @property
    def lane(self) -> Any:
        """The nearest lane."""
        return self.road.network.get_lane(self.lane_index)

    @lane.setter
    def lane(self, lane: Any) -> None:
        """Not kept."""

    def act(self, action: dict[str, float] | str | None = None) -> None:
        """Do nothing: everything is recorded."""

    def step(self, dt: float) -> None:
        """Go on to where the track is after a time, seconds."""
        # Whole steps are counted, so that times do not drift.
        self._steps, self._dt = self._steps + 1, dt
        x, y, heading, speed = self.tracks.state(self.row, self._begun + self._steps * dt)
        self.position = np.array([x, -y])
        self.heading, self.speed = mirrored_angle(heading), speed
        self.impact, self._lane_index = None, None
        if self.road.record_history:
            self.history.appendleft(Vehicle(None, self.position.copy(), self.heading, self.speed))


class ReactingVehicle(_Actor, IDMVehicle):  # type: ignore[misc]
    """An actor that begins as recorded, and drives on by highway-env's IDM and MOBIL.

    Args:
        tracks: The recorded actors.
        actor: Row of this one.
        road: The road that it is on.
        time: Seconds since the start of the tracks.
    """

    def __init__(self, tracks: Tracks, actor: int, road: Road, time: float = 0.0) -> None:
        _Actor.__init__(self, tracks, actor, road)
        x, y, heading, speed = tracks.state(actor, time)
        IDMVehicle.__init__(
            self,
            road,
            mirrored_points([x, y]),
            mirrored_angle(heading),
            speed,
            target_speed=speed,
        )


def _within(value: float, most: float) -> float:
    return min(max(value, -most), most)
