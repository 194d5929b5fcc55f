"""Budgets of queries: what is left, and who ends the episode."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from avsec_gym.envs.query_budget import QueryBudget
from avsec_gym.errors import ConfigurationError


def test_an_episode_ends_with_the_last_query() -> None:
    budget = QueryBudget(queries=3, usual=10)
    assert [budget.ends(spent) for spent in range(5)] == [False, False, False, True, True]
    assert QueryBudget(usual=2).ends(np.array([1, 2])).tolist() == [False, True]


def test_a_time_limit_below_the_queries_that_were_asked_for_is_refused() -> None:
    with pytest.raises(ConfigurationError, match=r"max_episode_steps=3 as well, or -1"):
        QueryBudget(queries=3).check_limit(2)
    QueryBudget(queries=3).check_limit(3)
    QueryBudget(queries=3).check_limit(None)
    QueryBudget(usual=10).check_limit(2)


def test_the_share_that_is_left_counts_down_to_none() -> None:
    assert [QueryBudget(queries=4).left(spent) for spent in (0, 1, 4)] == [1.0, 0.75, 0.0]
    np.testing.assert_array_equal(QueryBudget(usual=2).left(np.array([0, 1])), [1.0, 0.5])


@pytest.mark.parametrize(
    "wrong",
    [{"queries": 0}, {"price": float("nan")}, {"price": float("inf")}, {"price": "cheap"}],
    ids=str,
)
def test_a_budget_of_nothing_and_a_price_that_is_none_are_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(ConfigurationError, match=next(iter(wrong))):
        QueryBudget(**wrong)
