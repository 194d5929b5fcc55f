"""What an algorithm keeps to learn from: it has to fit into the memory."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from typing import Any

import gymnasium as gym
import numpy as np

from avsec_gym.agents.algorithms import algorithm_class
from avsec_gym.agents.configuration import AgentConfiguration
from avsec_gym.errors import ConfigurationError
from avsec_gym.machine_memory import half_of_memory


def check_kept_steps(
    configuration: AgentConfiguration,
    arguments: Mapping[str, Any],
    observations: gym.Space[Any],
) -> None:
    """Refuse steps that would fill the memory: the system would end the process in their middle.

    An off-policy algorithm keeps ``buffer_size`` steps, each with the observation before and after
    it; an on-policy one ``n_steps`` of each environment.

    Args:
        configuration: How the agent learns.
        arguments: Its algorithm's arguments; what they lack is the algorithm's default.
        observations: The space of one environment's observations.

    Raises:
        ConfigurationError: The observations take more than half of the machine's memory.
    """
    defaults = inspect.signature(algorithm_class(configuration.algorithm).__init__).parameters
    name = "buffer_size" if "buffer_size" in defaults else "n_steps"
    steps = arguments.get(name, defaults[name].default)
    each = 2 if name == "buffer_size" else configuration.n_envs
    needed, most = steps * each * bytes_of(observations), half_of_memory()
    if needed > most:
        raise ConfigurationError(
            f"{configuration.algorithm} keeps {name} = {steps:,} steps to learn from, here"
            f" {needed / 1e9:,.1f} GB of observations, more than half of this machine's memory"
            f" ({most / 1e9:,.1f} GB): give a smaller {name}"
        )


def bytes_of(space: gym.Space[Any]) -> int:
    """What one element of a space takes as arrays, bytes."""
    if isinstance(space, gym.spaces.Dict):
        return sum(map(bytes_of, space.spaces.values()))
    return int(np.prod(space.shape or (1,))) * np.dtype(space.dtype or np.int64).itemsize
