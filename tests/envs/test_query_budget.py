"""Budgets of queries: what is left, and who ends the episode."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from avsec_gym.envs.query_budget import QueryBudget
from avsec_gym.errors import ConfigurationError


def test_a_named_budget_ends_the_episode_whoever_made_the_environment() -> None:
    budget = QueryBudget(queries=3, usual=10)
    for has_time_limit in (False, True):
        ends = [budget.ends(spent, has_time_limit=has_time_limit) for spent in range(5)]
        assert ends == [False, False, False, True, True]


def test_without_a_name_the_time_limit_decides_where_there_is_one() -> None:
    budget = QueryBudget(usual=2)
    assert [budget.ends(spent, has_time_limit=False) for spent in (1, 2)] == [False, True]
    assert not budget.ends(20, has_time_limit=True)


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
