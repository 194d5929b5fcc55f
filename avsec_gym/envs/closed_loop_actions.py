"""The car of `avsec/ClosedLoop-v0` under highway-env's actions, and the actions checked."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import gymnasium as gym
import numpy as np
from highway_env.road.road import Road

from avsec_gym.closed_loop.road_frame import mirrored_angle, mirrored_points
from avsec_gym.closed_loop.traffic_scene import TrafficScene
from avsec_gym.closed_loop.vehicles import Car, CarWithMetaActions
from avsec_gym.errors import ConfigurationError

_META, _DIRECT = "DiscreteMetaAction", ("ContinuousAction", "DiscreteAction")
_SPEEDS = 5
"""Target speeds of meta-actions, from 0 to the scene's highest cruising speed."""


def car_on_road(scene: TrafficScene, road: Road, action: Mapping[str, Any]) -> Car:
    """The car at the start of a scene.

    Args:
        scene: The scene.
        road: highway-env's road of it.
        action: The part of highway-env's configuration that states what actions are.

    Raises:
        ConfigurationError: These actions are for several vehicles.
    """
    start = scene.start
    place = mirrored_points([start.x, start.y]), mirrored_angle(start.heading), start.velocity
    if action["type"] == _META:
        low, high = scene.cruise
        speeds = action.get("target_speeds")
        speeds = np.linspace(0.0, high, _SPEEDS) if speeds is None else np.asarray(speeds, float)
        car: Car = CarWithMetaActions(road, *place, target_speed=low, target_speeds=speeds)
    elif action["type"] in _DIRECT:
        car = Car(road, *place)
    else:
        raise ConfigurationError("one car is driven: multi-agent actions have none to drive")
    car.steering_angle = mirrored_angle(start.steering_angle)
    return car


def checked_driving(action: Any, space: gym.spaces.Space[Any]) -> Any:
    """An action as highway-env takes it, a copy.

    Args:
        action: What the agent gave.
        space: The action space.

    Raises:
        ConfigurationError: It does not fit the space, or is not finite.
    """
    if isinstance(space, gym.spaces.Discrete):
        if np.shape(action) != () or not space.contains(int(action)):
            raise ConfigurationError(
                f"an action is a number from 0 to {space.n - 1}, got {action!r}"
            )
        return int(action)
    shape = space.shape
    try:
        array = np.array(action, np.float64)
    except (TypeError, ValueError):
        array = np.full((0, 0), np.nan)
    if array.shape != shape or not np.isfinite(array).all():
        raise ConfigurationError(
            f"an action has shape {shape} and finite values in [-1, 1], got {action!r}"
        )
    return array
