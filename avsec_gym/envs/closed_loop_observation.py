"""What a driver is shown: its own state, its goal, and the objects that it believes in."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium import spaces
from highway_env.envs.common.observation import ObservationType, observation_factory
from highway_env.road.road import Road
from highway_env.vehicle.kinematics import Vehicle
from numpy.typing import NDArray

from avsec_gym.argument_checks import one_of, whole_number
from avsec_gym.attacks.attack import LEFT, RIGHT
from avsec_gym.closed_loop.belief import Belief
from avsec_gym.closed_loop.relative_poses import seen_from
from avsec_gym.closed_loop.road_frame import mirrored_angle, mirrored_points
from avsec_gym.closed_loop.traffic_scene import TrafficScene
from avsec_gym.envs.observations import FEATURES, THUMBNAIL, resized
from avsec_gym.errors import ConfigurationError
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.planning_scenario import EgoState
from avsec_gym.sensor_system import Sensor

OWN, EACH = 13, 9
"""Numbers about the car, and about each object."""
RANGE = 50.0
"""Metres of the plane that an observation's x reaches; its y reaches 20 m."""
OBSERVATIONS = (
    "Driver",
    "Frame",
    "Kinematics",
    "KinematicsGoal",
    "OccupancyGrid",
    "TimeToCollision",
    "LidarObservation",
    "GrayscaleObservation",
    "AttributesObservation",
    "ExitObservation",
    "TupleObservation",
)
"""Types of observations: two of this project, and highway-env's."""
MOST_PIXELS = 10_000
"""The largest side of an observed image, pixels."""


class DriverObservation(ObservationType):  # type: ignore[misc]
    """One flat vector in [-1, 1], in the car's own frame: x forward, y left.

    Args:
        env: The environment.
        objects: The number of nearest believed objects that are shown.
    """

    def __init__(self, env: Any, objects: int = 16, **_: Any) -> None:
        super().__init__(env)
        self.objects = objects

    def space(self) -> spaces.Box:
        """`Box(-1, 1, (13 + 9 objects,), float32)`."""
        return spaces.Box(-1.0, 1.0, (OWN + EACH * self.objects,), np.float32)

    def observe(self) -> NDArray[np.float32]:
        """The vector of the present belief."""
        env = self.env
        if env.road is None:
            return np.zeros(self.space().shape, np.float32)
        vector = np.concatenate(
            [
                about_the_car(env.scene, env.intention, env.state, env.remaining, env.belief),
                nearest_objects(env.state, env.belief, self.objects).ravel(),
            ]
        )
        return np.clip(vector, -1.0, 1.0).astype(np.float32)


class FrameObservation(ObservationType):  # type: ignore[misc]
    """What the car's sensors delivered last, and the vector of `DriverObservation`.

    Args:
        env: The environment, whose car reads images.
        size: Height and width that images are resized to, pixels.
        objects: The number of nearest believed objects that are shown.
    """

    def __init__(self, env: Any, size: Sequence[int] = THUMBNAIL, objects: int = 16, **_: Any):
        super().__init__(env)
        self._features = DriverObservation(env, objects)
        self.size = checked_size(size)

    def space(self) -> spaces.Dict:
        """`Dict`: `left` and `right`, (H, W, 3) uint8, and `features`."""
        image = spaces.Box(0, 255, (*self.size, 3), np.uint8)
        return spaces.Dict({"left": image, "right": image, FEATURES: self._features.space()})

    def observe(self) -> dict[str, Any]:
        """The last frame, and the present belief."""
        seen = {
            side: np.zeros((*self.size, 3), np.uint8)
            if self.env.road is None
            else resized(self.env.perception.frame.image(camera), self.size)
            for side, camera in (("left", LEFT), ("right", RIGHT))
        }
        return {**seen, FEATURES: self._features.observe()}


def checked_size(size: Sequence[int]) -> tuple[int, int]:
    """Height and width of observed images, pixels.

    Raises:
        ConfigurationError: These are no two whole numbers, each of 1 to `MOST_PIXELS`.
    """
    in_row = isinstance(size, np.ndarray) and size.ndim == 1
    if isinstance(size, str) or not (in_row or isinstance(size, Sequence)) or len(size) != 2:
        raise ConfigurationError(f"frame_size is a height and a width, got {size!r}")
    height, width = (whole_number("a side of frame_size", each, 1, MOST_PIXELS) for each in size)
    return height, width


def observing_frames(
    config: dict[str, Any] | None, size: tuple[int, int], read: frozenset[Sensor]
) -> dict[str, Any]:
    """The configuration with frames as observations.

    Args:
        config: highway-env's configuration, what differs from the default.
        size: Height and width of the images, pixels.
        read: The sensors that the perception reads.

    Raises:
        ConfigurationError: No images are read, or the configuration has an observation, too.
    """
    if not {LEFT, RIGHT} <= read:
        raise ConfigurationError(
            'observation="frame" shows images, and this perception does not read any: give'
            ' perception="sensors" or "stereo", or observation="features"'
        )
    if config is not None and "observation" in config:
        raise ConfigurationError(
            'observation="frame" and an observation in config: give one of them'
        )
    return {**(config or {}), "observation": {"type": "Frame", "size": [*size]}}


def about_the_car(
    scene: TrafficScene,
    intention: Intention,
    state: EgoState,
    remaining: tuple[float, float],
    belief: Belief,
) -> NDArray[np.float64]:
    """The first 13 numbers, in the order in which `avsec/ClosedLoop-v0` lists them, shape (13,)."""
    lanes = scene.lanes
    values = [state.velocity / 25.0, state.steering_angle / (math.pi / 4)]
    for lane in (lanes.at(state.x, state.y, state.heading), scene.target_lane(intention)):
        line = lanes.line(lane)
        along, left = line.coordinates(state.x, state.y)
        turned = math.remainder(state.heading - line.heading(along), 2 * math.pi)
        # Where the lane runs 15 m further on, to the left of straight ahead.
        ahead = seen_from((state.x, state.y, state.heading), np.array([line.pose(along + 15.0)]))[0]
        values += [left / 10.0, turned / math.pi, ahead[1] / 10.0]
    values += [remaining[0] / 100.0, remaining[1], scene.cruise[0] / 25.0]
    values += [float(belief.road_type == RoadType.HIGHWAY), float(belief.stops)]
    return np.array(values)


def nearest_objects(state: EgoState, belief: Belief, count: int) -> NDArray[np.float64]:
    """The nearest objects: present, x, y, vx, vy, cos, sin, length, width; shape (count, 9)."""
    rows = np.zeros((count, EACH))
    if not len(belief.poses):
        return rows
    poses = seen_from((state.x, state.y, state.heading), belief.poses)
    nearest = np.argsort(np.hypot(poses[:, 0], poses[:, 1]), kind="stable")[:count]
    x, y, heading = poses[nearest].T
    cos, sin = np.cos(heading), np.sin(heading)
    speed = belief.speeds[nearest]
    own = np.column_stack(
        [
            np.ones(len(nearest)),
            x / RANGE,
            y / 20.0,
            (speed * cos - state.velocity) / 25.0,
            speed * sin / 25.0,
            cos,
            sin,
            belief.lengths[nearest] / 20.0,
            belief.widths[nearest] / 4.0,
        ]
    )
    rows[: len(own)] = own
    return rows


class BelievedRoad:
    """The environment as highway-env's observations see it, with believed objects on the road.

    Args:
        env: The environment.
    """

    def __init__(self, env: Any) -> None:
        self._env = env

    def __getattr__(self, name: str) -> Any:
        return getattr(self._env, name)

    @property
    def road(self) -> Road | None:
        """The road, the car, and the objects that it believes in."""
        env = self._env
        if env.road is None:
            return None
        believed = Road(network=env.road.network, np_random=env.road.np_random)
        believed.vehicles = [env.vehicle, *believed_vehicles(believed, env.belief)]
        return believed


def believed_vehicles(
    road: Road, belief: Belief, chosen: NDArray[np.bool_] | slice = slice(None)
) -> list[Vehicle]:
    """Believed objects as vehicles of highway-env.

    Args:
        road: The road that they are on.
        belief: N believed objects.
        chosen: Which of them, shape (N,).
    """
    columns = (belief.poses, belief.speeds, belief.lengths, belief.widths)
    return [
        _believed(road, *row)
        for row in zip(*(each[chosen].tolist() for each in columns), strict=True)
    ]


def _believed(road: Road, pose: list[float], speed: float, length: float, width: float) -> Vehicle:
    vehicle = Vehicle(road, mirrored_points(pose[:2]), mirrored_angle(pose[2]), speed)
    vehicle.LENGTH, vehicle.WIDTH = length, width
    return vehicle


def observation_of(env: Any, config: dict[str, Any]) -> ObservationType:
    """The observation that a configuration names.

    Args:
        env: The environment.
        config: ``{"type": "Driver"}``; ``{"type": "Frame"}``; or one of highway-env's, which shows
            believed objects.

    Raises:
        ConfigurationError: There is no such observation.
    """
    kind = one_of("observation", config.get("type"), OBSERVATIONS)
    if kind == "Driver":
        return DriverObservation(env, **config)
    if kind == "Frame":
        return FrameObservation(env, **config)
    return observation_factory(BelievedRoad(env), config)
