"""How often an attacker may query the car in an episode, and what that costs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from avsec_gym.argument_checks import number, whole_number


@dataclass(frozen=True)
class QueryBudget:
    """The budget that observations count down.

    Args:
        queries: Queries of an episode, which ends with the last; None: `usual`, and Gymnasium's
            time limit ends the episode where there is one.
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

    def ends(self, spent: int, *, has_time_limit: bool) -> bool:
        """Whether the episode is over after so many queries.

        Args:
            spent: Queries of the episode.
            has_time_limit: Whether `gym.make` made the environment: its time limit, which an
                environment does not know, then decides, unless a budget was named.
        """
        return (self.queries is not None or not has_time_limit) and spent >= self.count
