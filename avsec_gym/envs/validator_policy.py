"""`ValidatorPolicy`: any validator as an agent with the interface of stable-baselines3."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import ConfigurationError
from avsec_gym.registry import Kind, make


class ValidatorPolicy:
    """A validator that plays `avsec/SensorIdentification-v0`.

    Args:
        validator: A name with its arguments, or a live validator; see `avsec_gym.registry.make`.
        environment: The environment that is played, whose frames the validator sees.

    Raises:
        ConfigurationError: The validator judges other sensors than the environment has.

    Example:
        >>> from stable_baselines3.common.evaluation import evaluate_policy
        >>> env = gym.make("avsec/SensorIdentification-v0")  # doctest: +SKIP
        >>> thresholds = {"name": "thresholds", "thresholds": "runs/validate/thresholds.json"}
        >>> evaluate_policy(ValidatorPolicy(thresholds, env), env)  # doctest: +SKIP
    """

    def __init__(self, validator: Any, environment: gym.Env[Any, Any]) -> None:
        self.validator = make(Kind.VALIDATOR, validator)
        played: Any = environment.unwrapped
        self._environment = played
        own, played = self.validator.system.sensors, self._environment.system.sensors
        if own != played:
            raise ConfigurationError(
                f"the validator judges {own}, the environment asks for {played}"
            )

    def predict(
        self,
        observation: NDArray[np.float32],
        state: Any = None,
        episode_start: Any = None,
        deterministic: bool = True,
    ) -> tuple[NDArray[np.int8], Any]:
        """The action for the frame that is played.

        Args:
            observation: One, or a batch of one.
            state: The state, which is handed through.
            episode_start: An argument of the interface that is not used: a validator remembers
                nothing.
            deterministic: Validators always are.

        Returns:
            Flags, shape (sensors,) or (1, sensors), and the state.
        """
        attacked = self.validator.validate(self._environment.frame).attacked
        sensors = self._environment.system.sensors
        flags = np.array([sensor in attacked for sensor in sensors], np.int8)
        return flags.reshape(*observation.shape[:-1], len(sensors)), state
