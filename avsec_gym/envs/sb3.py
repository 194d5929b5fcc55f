"""Gymnasium's vector environments for stable-baselines3, whose own vector interface differs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv
from stable_baselines3.common.vec_env.base_vec_env import VecEnvObs, VecEnvStepReturn

from avsec_gym.argument_checks import shown
from avsec_gym.errors import ConfigurationError


class StableBaselinesVecEnv(VecEnv):
    """A Gymnasium vector environment with the interface of stable-baselines3.

    Episodes that end begin anew in the same step, as stable-baselines3 expects; the last
    observation goes into ``terminal_observation``.

    Args:
        environment: One with autoreset mode NEXT_STEP, and resets by ``options["reset_mask"]``.

    Raises:
        ConfigurationError: The environment resets otherwise.
    """

    def __init__(self, environment: VectorEnv[Any, Any, Any]) -> None:
        if environment.metadata.get("autoreset_mode") != AutoresetMode.NEXT_STEP:
            raise ConfigurationError("only vector environments with autoreset NEXT_STEP fit")
        self.environment = environment
        self.render_mode = environment.render_mode
        super().__init__(
            environment.num_envs,
            environment.single_observation_space,
            environment.single_action_space,
        )
        self._actions: NDArray[Any] = np.zeros(0)

    def reset(self) -> VecEnvObs:
        """Begin all episodes, with the seeds of `seed` and the options of `set_options`.

        Raises:
            ConfigurationError: The options differ.
        """
        given = self._seeds[0] if self._seeds and self._seeds[0] is not None else None
        options = self._options[0]
        if self._options.count(options) != self.num_envs:
            raise ConfigurationError(
                f"one batch resets with the same options everywhere, got {shown(self._options)}:"
                " give set_options one dictionary, or make single environments with"
                " stable_baselines3.common.env_util.make_vec_env"
            )
        observations, _ = self.environment.reset(seed=given, options=options or None)
        self._reset_seeds()
        self._reset_options()
        return observations

    def step_async(self, actions: NDArray[Any]) -> None:
        """Keep the actions for `step_wait`."""
        self._actions = actions

    def step_wait(self) -> VecEnvStepReturn:
        """Take a step in every environment."""
        observations, rewards, terminated, truncated, info = self.environment.step(self._actions)
        names = [name for name in info if not name.startswith("_")]
        infos = [
            {name: _plain(info[name][i]) for name in names}
            | {"TimeLimit.truncated": bool(truncated[i] and not terminated[i])}
            for i in range(self.num_envs)
        ]
        ended = np.asarray(terminated | truncated, bool)
        if ended.any():
            for i in np.nonzero(ended)[0]:
                infos[i]["terminal_observation"] = observations[i].copy()
            fresh, _ = self.environment.reset(options={"reset_mask": ended})
            observations = np.where(ended[:, None], fresh, observations)
        return observations, np.asarray(rewards, np.float32), ended, infos

    def close(self) -> None:
        """Close the environment."""
        self.environment.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """The same attribute of the one environment for each index."""
        value = getattr(self.environment, attr_name)
        return [value for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Set an attribute of the one environment."""
        setattr(self.environment, attr_name, value)

    def env_method(
        self, method_name: str, *method_args: Any, indices: Any = None, **method_kwargs: Any
    ) -> list[Any]:
        """Not available: the environments are one batch."""
        raise NotImplementedError("the environments of a batch have no methods of their own")

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """None is."""
        return [False for _ in self._get_indices(indices)]

    def get_images(self) -> Sequence[NDArray[np.uint8] | None]:
        """None: batches are not rendered."""
        return [None] * self.num_envs


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value
