"""A configuration as something that learns: environments and an algorithm of stable-baselines3."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import gymnasium as gym

import avsec_gym
from avsec_gym.agents.algorithms import algorithm_class, plain_arguments, policy_named
from avsec_gym.agents.configuration import AgentConfiguration
from avsec_gym.agents.kept_steps import check_kept_steps
from avsec_gym.errors import ConfigurationError

_UNFIT = (
    TypeError,
    ValueError,
    AssertionError,
    RuntimeError,
    AttributeError,
    ArithmeticError,
    MemoryError,
)
"""What the libraries raise of arguments that do not fit."""


def make_learner(configuration: AgentConfiguration, seed: int) -> Any:
    """An agent that has learned nothing yet, in its environments.

    Args:
        configuration: How it learns.
        seed: Seed of its weights, its exploration and its environments.

    Raises:
        ConfigurationError: The arguments do not fit the algorithm or the environment, or what the
            algorithm keeps to learn from takes more than half of the machine's memory.
    """
    from stable_baselines3.common.utils import set_random_seed

    set_random_seed(seed)
    environments = training_environments(configuration)
    try:
        arguments = plain_arguments(configuration.arguments, configuration.algorithm)
        check_kept_steps(configuration, arguments, environments.observation_space)
        return algorithm_class(configuration.algorithm)(
            policy_named(configuration.policy),
            environments,
            seed=seed,
            device="cpu",
            **arguments,
        )
    except _UNFIT as error:
        raise _unfit(configuration, error) from error


def training_environments(configuration: AgentConfiguration) -> Any:
    """The environments to learn in, side by side, with the interface of stable-baselines3."""
    from stable_baselines3.common.vec_env import DummyVecEnv, VecMonitor

    from avsec_gym.envs.sb3 import StableBaselinesVecEnv

    count, arguments = configuration.n_envs, configuration.env_kwargs
    if has_batches(configuration.env, arguments):
        return VecMonitor(StableBaselinesVecEnv(batch_of(configuration.env, count, arguments)))
    return VecMonitor(DummyVecEnv([lambda: single(configuration.env, arguments)] * count))


def make_policy(configuration: AgentConfiguration, environment: gym.Env[Any, Any]) -> Any:
    """The policy alone, untrained, for the spaces of an environment.

    Raises:
        ConfigurationError: The arguments do not fit.
    """
    named = policy_named(configuration.policy)
    if isinstance(named, str):
        aliases = algorithm_class(configuration.algorithm).policy_aliases
        if named not in aliases:
            raise ConfigurationError(
                f"{configuration.algorithm} has no policy {named!r}: it has {', '.join(aliases)}"
            )
        named = aliases[named]
    arguments = plain_arguments(configuration.arguments, configuration.algorithm)
    own = dict(arguments.get("policy_kwargs", {}))
    if arguments.get("use_sde"):
        own["use_sde"] = True
    try:
        seen = _channels_first(environment.observation_space)
        policy = named(seen, environment.action_space, lambda _: 0.0, **own)
    except _UNFIT as error:
        raise _unfit(configuration, error) from error
    policy.set_training_mode(False)
    return policy


def _channels_first(space: gym.Space[Any]) -> gym.Space[Any]:
    """A space as stable-baselines3 trains in it: the colours of images are their first axis.

    Its policies take images of either form when they predict.
    """
    from stable_baselines3.common.preprocessing import (
        is_image_space,
        is_image_space_channels_first,
    )
    from stable_baselines3.common.vec_env import VecTransposeImage

    if isinstance(space, gym.spaces.Dict):
        return gym.spaces.Dict({name: _channels_first(part) for name, part in space.items()})
    if not isinstance(space, gym.spaces.Box) or not is_image_space(space):
        return space
    first = is_image_space_channels_first(space)
    return space if first else VecTransposeImage.transpose_space(space)


def has_batches(env: str, arguments: Mapping[str, Any]) -> bool:
    """Whether an environment has a vectorised entry point that takes these arguments.

    Those of the closed loop refuse some that a single environment takes, such as sensors.
    """
    gym.register_envs(avsec_gym)
    if gym.spec(env).vector_entry_point is None:
        return False
    try:
        batch_of(env, 1, arguments).close()
    except ConfigurationError:
        return False
    return True


def single(env: str, arguments: Mapping[str, Any]) -> gym.Env[Any, Any]:
    """One environment."""
    gym.register_envs(avsec_gym)
    with _no_word_of_versions():
        return gym.make(env, disable_env_checker=True, **_no_limit(arguments), **arguments)


def batch_of(env: str, count: int, arguments: Mapping[str, Any]) -> Any:
    """Many environments that are one batch."""
    gym.register_envs(avsec_gym)
    with _no_word_of_versions():
        return gym.make_vec(env, num_envs=count, **_no_limit(arguments), **arguments)


def _no_limit(arguments: Mapping[str, Any]) -> dict[str, Any]:
    """What frees a budget of queries, where one is given, of Gymnasium's time limit."""
    return {} if arguments.get("queries") is None else {"max_episode_steps": -1}


@contextmanager
def _no_word_of_versions() -> Iterator[None]:
    """Gymnasium points from v0 to v1; who asks for v0 means it."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", ".*is out of date.*", DeprecationWarning)
        yield


def _unfit(configuration: AgentConfiguration, error: Exception) -> ConfigurationError:
    return ConfigurationError(
        f"the configuration of {configuration.algorithm} for {configuration.env} does not fit:"
        f" {' '.join(str(error).split())[:300]}"
    )
