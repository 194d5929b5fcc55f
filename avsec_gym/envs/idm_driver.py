"""highway-env's own driver at the wheel: the baseline that needs no plan."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from highway_env.road.road import Road
from highway_env.vehicle.behavior import IDMVehicle

from avsec_gym.closed_loop.belief import Belief
from avsec_gym.closed_loop.relative_poses import seen_from
from avsec_gym.closed_loop.road_frame import mirrored_angle, mirrored_points
from avsec_gym.closed_loop.road_network import network_of
from avsec_gym.closed_loop.traffic_scene import TrafficScene
from avsec_gym.closed_loop.vehicles import MOST_ACCELERATION
from avsec_gym.envs.belief_driver import BeliefDriver
from avsec_gym.envs.closed_loop_observation import believed_vehicles
from avsec_gym.planners.vehicle import BMW_320I
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.planning_scenario import EgoState

_REACH = 100.0
"""Metres from the car beyond which believed objects are left out: IDM looks at neighbours."""
_LEAST_AHEAD, _SECONDS_AHEAD = 6.0, 1.2
"""Metres, and seconds of driving, that the point that is steered to lies ahead."""


class IdmDriver(BeliefDriver):
    """The Intelligent Driver Model drives `avsec/ClosedLoop-v0` on what the car believes.

    IDM (Treiber et al. 2000), with highway-env's constants, keeps the distance to what is believed
    to be ahead in the lane, and otherwise drives at the highest cruising speed of the scene.  It
    changes lanes only as the intention asks, once MOBIL (Kesting et al. 2007) holds that to be safe
    for who drives behind there.  Pure pursuit (Coulter 1992) steers: highway-env's own controller
    turns the wheels at once, and swings from side to side where they turn at 0.4 rad/s.  It makes
    no plan: it neither evades what stands at the edge of its lane, nor looks at what crosses it.
    Where a validator makes the car stop, it brakes fully.

    Args:
        environment: The environment that is driven, with continuous actions.

    Raises:
        ConfigurationError: The environment's actions are not continuous.

    Example:
        >>> import gymnasium as gym
        >>> env = gym.make("avsec_gym:avsec/ClosedLoop-v0")
        >>> driver = IdmDriver(env)
        >>> observation, _ = env.reset(seed=0)
        >>> action, _ = driver.predict(observation)
        >>> action.shape
        (2,)
    """

    def begin(self) -> None:
        """A new drive has begun."""
        self._wheel = _Wheel(self.played.scene, self.played.intention, self.played.state)

    def controls(self) -> tuple[float, float]:
        """The controls of IDM and of pure pursuit."""
        played = self.played
        return self._wheel.controls(played.state, played.belief, played.elapsed)


class _Wheel:
    """IDM in one drive.

    Args:
        scene: Where the car drives.
        intention: The lane that it wants to reach.
        start: Where it begins.
    """

    def __init__(self, scene: TrafficScene, intention: Intention, start: EgoState) -> None:
        self._line = scene.lanes.line(scene.target_lane(intention))
        network = network_of(scene.lanes, speed_limit=scene.cruise[1])
        self._road = Road(network=network, neighbour_vehicles_connected_lanes=True)
        self._car = _IdmCar(self._road, *_placed(start), target_speed=scene.cruise[1])
        self._elapsed = 0.0

    def controls(self, state: EgoState, belief: Belief, elapsed: float) -> tuple[float, float]:
        """Acceleration, m/s2, and steering angle, radians to the left.

        Args:
            state: The state that the car has really reached.
            belief: The car's present belief.
            elapsed: Seconds since the start of the drive.
        """
        car = self._car
        car.position, car.heading, car.speed = _placed(state)
        car.on_state_update()
        car.timer += elapsed - self._elapsed
        self._elapsed = elapsed
        # MOBIL changes towards the lane of the route alone.
        along, _ = self._line.coordinates(state.x, state.y)
        x, y, heading = self._line.pose(along)
        place = mirrored_points([x, y]), mirrored_angle(heading)
        car.route = [self._road.network.get_closest_lane_index(*place)]
        pose = (state.x, state.y, state.heading)
        near = np.hypot(*seen_from(pose, belief.poses)[:, :2].T) < _REACH
        others = believed_vehicles(self._road, belief, near)
        # MOBIL asks how hard one behind would brake, who wants to go on at its speed.
        for other in others:
            other.target_speed = other.speed
        self._road.vehicles = [car, *others]
        car.act()
        acceleration = float(car.action["acceleration"])
        if belief.stops:
            acceleration = -MOST_ACCELERATION
        return acceleration, mirrored_angle(float(car.action["steering"]))


class _IdmCar(IDMVehicle):  # type: ignore[misc]
    """highway-env's driver in a car of this size and this steering."""

    LENGTH, WIDTH = BMW_320I.length, BMW_320I.width

    def steering_control(self, target_lane_index: Any) -> float:
        """The angle of the wheels that leads the rear axle in a circle to the lane's middle ahead.

        Args:
            target_lane_index: highway-env's index of the lane.

        Returns:
            Radians to the right.
        """
        rear = self.position - BMW_320I.rear_axle * self.direction
        lane = self.road.network.get_lane(target_lane_index)
        along, _ = lane.local_coordinates(rear)
        ahead = max(_LEAST_AHEAD, _SECONDS_AHEAD * self.speed)
        apart = lane.position(along + ahead, 0.0) - rear
        bearing = math.atan2(apart[1], apart[0]) - self.heading
        return math.atan(2.0 * BMW_320I.wheelbase * math.sin(bearing) / math.hypot(*apart))


def _placed(state: EgoState) -> tuple[Any, float, float]:
    """Position, heading and speed in highway-env's plane."""
    return mirrored_points([state.x, state.y]), mirrored_angle(state.heading), state.velocity
