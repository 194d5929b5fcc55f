"""Environments without highway-env, many at once, as a vector environment of Gymnasium."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Generic, TypeVar

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from avsec_gym.argument_checks import whole_number
from avsec_gym.envs.reset_options import reset_options
from avsec_gym.envs.vector_resets import mask_of, seeds_of
from avsec_gym.errors import ConfigurationError

MOST_ENVIRONMENTS = 4096
"""Each has a drive of its own."""
ALONE = 'make single environments: gym.make_vec(..., vectorization_mode="sync")'

One = TypeVar("One", bound=gym.Env[Any, Any])


class ManyDrives(
    VectorEnv[NDArray[np.float32], NDArray[np.float32], NDArray[np.float64]], Generic[One]
):
    """Single environments, one after the other, in one process.

    A drive that has ended begins anew at the next step, whose action is not used (autoreset mode
    NEXT_STEP).  Environment i, seeded with s, drives what a single one seeded with s + i drives.

    Args:
        alone: The single environments, with flat observations and actions.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012 - as Gymnasium declares it
        "render_modes": [],
        "autoreset_mode": AutoresetMode.NEXT_STEP,
    }
    render_mode = None

    def __init__(self, alone: Sequence[One]) -> None:
        self.alone, self.num_envs = alone, len(alone)
        self.single_action_space = alone[0].action_space
        self.single_observation_space = alone[0].observation_space
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.ended: NDArray[np.bool_] = np.zeros(self.num_envs, bool)
        """Whose drive is over, and begins anew at the next step, shape (num_envs,)."""
        self._infos: list[dict[str, Any]] = []

    def reset(
        self,
        *,
        seed: int | list[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begin all drives, or those of ``options["reset_mask"]``.

        Raises:
            ConfigurationError: There is no such scene, or it has no lane for the intention.
        """
        options = reset_options(options, "reset_mask")
        everywhere = np.ones(self.num_envs, bool)
        mask = mask_of(options.pop("reset_mask", everywhere), self.num_envs)
        seeds = seeds_of(seed, self.num_envs)
        if not self._infos:
            mask = everywhere
            self._seen = np.zeros(self.observation_space.shape or (), np.float32)
            self._infos = [{}] * self.num_envs
        for i in np.flatnonzero(mask).tolist():
            self._seen[i], self._infos[i] = self.alone[i].reset(seed=seeds[i], options=options)
        self.ended[mask] = False
        return self._seen.copy(), self._info()

    def step(  # type: ignore[override]
        self, actions: NDArray[np.float32]
    ) -> tuple[
        NDArray[np.float32],
        NDArray[np.float64],
        NDArray[np.bool_],
        NDArray[np.bool_],
        dict[str, Any],
    ]:
        """One step everywhere; drives that are over begin anew instead.

        Raises:
            ResetNeeded: There was no reset before.
            ConfigurationError: The actions do not fit the space, or are not finite.
        """
        if not self._infos:
            raise gym.error.ResetNeeded("call reset before step")
        actions = np.array(actions, float)
        if actions.shape != self.action_space.shape or not np.isfinite(actions).all():
            raise ConfigurationError(
                f"actions have shape {self.action_space.shape} and finite values, got "
                f"{actions.shape}"
            )
        rewards = np.zeros(self.num_envs)
        terminated, truncated = np.zeros((2, self.num_envs), bool)
        for i, alone in enumerate(self.alone):
            if self.ended[i]:
                self._seen[i], self._infos[i] = alone.reset()
            else:
                self._seen[i], rewards[i], terminated[i], truncated[i], self._infos[i] = alone.step(
                    actions[i]
                )
        self.ended = terminated | truncated
        return self._seen.copy(), rewards, terminated, truncated, self._info()

    def _info(self) -> dict[str, Any]:
        info: dict[str, Any] = {}
        for name, value in self._infos[0].items():
            kind = object if isinstance(value, str) else type(value)
            info[name] = np.array([each[name] for each in self._infos], kind)
            info[f"_{name}"] = np.ones(self.num_envs, bool)
        return info


def checked_count(num_envs: Any) -> int:
    """The number of environments.

    Raises:
        ConfigurationError: It is out of range.
    """
    return whole_number("num_envs", num_envs, 1, MOST_ENVIRONMENTS)
