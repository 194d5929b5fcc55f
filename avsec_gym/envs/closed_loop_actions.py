"""The car of `avsec/ClosedLoop-v0` under highway-env's actions, and the actions checked."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import gymnasium as gym
import numpy as np
from highway_env.envs.common.action import ActionType, action_factory
from highway_env.road.road import Road

from avsec_gym.argument_checks import one_of
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
    """
    start = scene.start
    place = mirrored_points([start.x, start.y]), mirrored_angle(start.heading), start.velocity
    if action["type"] == _META:
        low, high = scene.cruise
        speeds = action.get("target_speeds")
        speeds = np.linspace(0.0, high, _SPEEDS) if speeds is None else np.asarray(speeds, float)
        car: Car = CarWithMetaActions(road, *place, target_speed=low, target_speeds=speeds)
    else:
        car = Car(road, *place)
    car.steering_angle = mirrored_angle(start.steering_angle)
    return car


def action_of(env: Any, config: dict[str, Any]) -> ActionType:
    """The actions that a configuration names.

    Args:
        env: The environment.
        config: A type of highway-env's, such as ``{"type": "DiscreteMetaAction"}``.

    Raises:
        ConfigurationError: There is no such type, or it is for several vehicles.
    """
    one_of("type of actions", config.get("type"), (_META, *_DIRECT))
    return action_factory(env, config)


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
