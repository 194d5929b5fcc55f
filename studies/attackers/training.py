"""SAC that learns to attack sensors, from few queries."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import gymnasium as gym
import torch
from stable_baselines3 import SAC


class CountedQueries(gym.Wrapper[Any, Any, Any, Any]):
    """An environment that reports after every query how many are done, and of how many.

    Args:
        env: The environment.
        queries: The number of all.
        on_query: Function that gets both numbers.
    """

    def __init__(
        self, env: gym.Env[Any, Any], queries: int, on_query: Callable[[int, int], object]
    ) -> None:
        super().__init__(env)
        self._asked, self._queries, self._on_query = 0, queries, on_query

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """The environment's step, counted."""
        self._asked += 1
        self._on_query(min(self._asked, self._queries), self._queries)
        return self.env.step(action)


def trained(env: gym.Env[Any, Any], queries: int, seed: int) -> SAC:
    """SAC after some queries: they are dear, so every one is learned from many times.

    Args:
        env: The environment that it learns in.
        queries: The number of queries.
        seed: Seed of the training.
    """
    torch.set_num_threads(1)
    agent = SAC(
        "MlpPolicy",
        env,
        learning_starts=queries // 4,
        gradient_steps=4,
        batch_size=128,
        learning_rate=1e-3,
        gamma=0.5,  # Queries hardly depend on each other.
        ent_coef=0.02,  # As an automatic one begins, the rare reward of 1 is not felt.
        policy_kwargs={"net_arch": [64, 64]},
        seed=seed,
        device="cpu",
    )
    return agent.learn(queries)
