"""Searches for an action that attacks sensors without looking: random search and CMA-ES."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from avsec_gym.agents.extras import cma_module
from avsec_gym.geometry import Floats

TRIALS = 4
"""Training episodes that a search tries an action in."""
QUERIES = 10
"""Queries of an episode."""
FEWEST_STEPS = 48
"""What the first generation of CMA-ES spends on perturbations: 12 actions, each tried 4 times."""

Actions = NDArray[np.float32]
"""Actions of A numbers in [-1, 1], shape (K, A)."""


def random_search(env: gym.Env[Any, Any], queries: int, seed: int) -> Actions:
    """The best of random actions, best first.

    Args:
        env: The environment that they are tried in.
        queries: The number of queries.
        seed: Seed of the actions and of the episodes.
    """
    generator = np.random.default_rng(seed)
    shape: Any = env.action_space.shape
    actions = generator.uniform(-1.0, 1.0, (queries // TRIALS, *shape))
    env.reset(seed=seed)
    return _best_first(actions, [_reward_of(env, action) for action in actions])


def evolved(env: gym.Env[Any, Any], queries: int, seed: int) -> Actions:
    """The best actions of an evolution strategy that adapts its covariances, best first.

    Args:
        env: The environment that they are tried in.
        queries: The largest number of queries.
        seed: Seed of the strategy and of the episodes.
    """
    return _best_first(*_evolution(env, queries, seed)[1:])


def favourite(env: gym.Env[Any, Any], queries: int, seed: int) -> NDArray[np.float32]:
    """The middle of where the evolution strategy looks in the end, shape (A,).

    Args:
        env: The environment that actions are tried in.
        queries: The largest number of queries.
        seed: Seed of the strategy and of the episodes.
    """
    strategy, *_ = _evolution(env, queries, seed)
    return np.asarray(strategy.result.xfavorite, np.float32)


def _evolution(env: gym.Env[Any, Any], queries: int, seed: int) -> tuple[Any, Floats, list[float]]:
    """Where the strategy ended, the actions that it tried, and what they earned."""
    options = {"bounds": [-1.0, 1.0], "seed": seed + 1, "verbose": -9}  # 0 would be the clock
    shape: Any = env.action_space.shape
    strategy = cma_module().CMAEvolutionStrategy(np.zeros(shape), 0.5, options)
    actions: list[Floats] = []
    rewards: list[float] = []
    env.reset(seed=seed)
    while len(actions) + strategy.popsize <= queries // TRIALS:
        asked = strategy.ask()
        paid = [_reward_of(env, action) for action in asked]
        strategy.tell(asked, [-reward for reward in paid])
        actions, rewards = actions + asked, rewards + paid
    return strategy, np.array(actions), rewards


def _reward_of(env: gym.Env[Any, Any], action: Floats) -> float:
    """What an action earns in some training episodes as their first query."""
    total = 0.0
    for _ in range(TRIALS):
        env.reset()
        total += float(env.step(action.astype(np.float32))[1])
    return total


def _best_first(actions: Floats, rewards: list[float]) -> Actions:
    """As many as an episode has queries."""
    return actions[np.argsort(-np.array(rewards), kind="stable")[:QUERIES]].astype(np.float32)
