"""What drivers that read the car's belief have in common: the interface of stable-baselines3."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from avsec_gym.envs.driving_actions import driving_action
from avsec_gym.errors import ConfigurationError


class BeliefDriver(ABC):
    """Drives `avsec/ClosedLoop-v0` by what the car believes, which it reads from the environment.

    Args:
        environment: The environment that is driven, with continuous actions.

    Raises:
        ConfigurationError: The environment's actions are not continuous.
    """

    def __init__(self, environment: gym.Env[Any, Any]) -> None:
        played: Any = environment.unwrapped
        self.played = played
        if played.action_ranges is None:
            raise ConfigurationError(f"{type(self).__name__} drives by continuous actions")
        self._drive: Any = None

    @abstractmethod
    def begin(self) -> None:
        """A new drive has begun."""

    @abstractmethod
    def controls(self) -> tuple[float, float]:
        """The acceleration, m/s2, and the steering angle, radians to the left, of this instant."""

    def predict(
        self,
        observation: Any,
        state: Any = None,
        episode_start: Any = None,
        deterministic: bool = True,
    ) -> tuple[NDArray[np.float32], Any]:
        """The action at the present instant of the drive.

        Args:
            observation: One, or a batch of one; the belief is read from the environment.
            state: The state, which is handed through.
            episode_start: An argument of the interface that is not used: a new drive is recognised
                by itself.
            deterministic: An argument of the interface that is not used: the action always is.

        Returns:
            Actions in [-1, 1], shape (2,) or (1, 2), and the state.
        """
        if self._drive is not self.played.drive:
            self._drive = self.played.drive
            self.begin()
        action = driving_action(self.controls(), self.played.action_ranges)
        return action.reshape(*np.shape(observation)[:-1], 2), state
