"""How often an attacker may query the car in an episode, and what that costs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from avsec_gym.errors import ConfigurationError


@dataclass(frozen=True)
class QueryBudget:
    """The budget that observations count down.

    Args:
        queries: Queries of an episode, which ends with the last; None: `usual`, and Gymnasium's
            time limit ends the episode where there is one.
        price: Reward that a query costs, and each thing that it uses.
        usual: Budget of the registered id, its `max_episode_steps`.

    Raises:
        ConfigurationError: Fewer than one query, or a price that is not a finite number.
    """

    queries: int | None = None
    price: float = 0.02
    usual: int = 10

    def __post_init__(self) -> None:
        if not isinstance(self.price, int | float) or not np.isfinite(self.price):
            raise ConfigurationError(f"price is a finite number, got {self.price!r}")
        if self.queries is not None and self.queries < 1:
            raise ConfigurationError(f"queries is 1 or more, got {self.queries}")

    @property
    def count(self) -> int:
        """Queries of an episode."""
        return self.usual if self.queries is None else self.queries

    def left(self, spent: Any) -> Any:
        """Share of the queries that is left after some were spent; a number, or an array."""
        return 1.0 - spent / self.count

    def ends(self, spent: int, *, has_time_limit: bool) -> bool:
        """Whether the episode is over after so many queries.

        Args:
            spent: Queries of the episode.
            has_time_limit: Whether `gym.make` made the environment: its time limit, which an
                environment is not told of, then decides, unless a budget was named.
        """
        return (self.queries is not None or not has_time_limit) and spent >= self.count
