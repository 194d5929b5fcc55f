"""How often an attacker may query the car in an episode, and what that costs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from avsec_gym.argument_checks import number, whole_number
from avsec_gym.errors import ConfigurationError


@dataclass(frozen=True)
class QueryBudget:
    """The budget that observations count down; the episode ends with the last query.

    That is a termination: what is left is part of the observation, and so of the Markov decision
    process.

    Args:
        queries: Queries of an episode; None: `usual`.
        price: Reward that a query costs, and each thing that it uses, from 0 to 1.
        usual: Budget of the registered id, its `max_episode_steps`.

    Raises:
        ConfigurationError: Fewer than one query, or a price that is out of range.
    """

    queries: int | None = None
    price: float = 0.02
    usual: int = 10

    def __post_init__(self) -> None:
        object.__setattr__(self, "price", number("price", self.price, 0.0, 1.0))
        if self.queries is not None:
            object.__setattr__(self, "queries", whole_number("queries", self.queries, 1))

    @property
    def count(self) -> int:
        """Queries of an episode."""
        return self.usual if self.queries is None else self.queries

    def left(self, spent: Any) -> Any:
        """Share of the queries that is left after some were spent; a number, or an array."""
        return 1.0 - spent / self.count

    def ends(self, spent: Any) -> Any:
        """Whether the episode is over after so many queries; a number, or an array."""
        return spent >= self.count

    def check_limit(self, max_episode_steps: int | None) -> None:
        """Refuse a time limit that would cut episodes before the queries that were asked for.

        Args:
            max_episode_steps: Steps after which Gymnasium cuts an episode; None: there is no limit.

        Raises:
            ConfigurationError: `queries` was given, and the limit is smaller.
        """
        queries, limit = self.queries, max_episode_steps
        if queries is not None and limit is not None and queries > limit:
            raise ConfigurationError(
                f"queries={queries} takes {queries} steps, and Gymnasium cuts an episode after"
                f" {limit}: pass max_episode_steps={queries} as well, or -1 for no limit"
            )
