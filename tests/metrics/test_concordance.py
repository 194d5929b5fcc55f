"""Areas under ROC curves against scipy, and against counting pairs."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import mannwhitneyu

from avsec_gym.metrics.concordance import concordance

CASES = st.lists(
    st.tuples(st.integers(0, 4), st.booleans(), st.integers(0, 2), st.integers(0, 3)), max_size=25
)


def by_pairs(cases: list[tuple[int, bool, int, int]]) -> float:
    pairs = won = 0.0
    for score, hit, group, weight in cases:
        for other, other_hit, other_group, other_weight in cases:
            if hit and not other_hit and group == other_group:
                pairs += weight * other_weight
                won += weight * other_weight * (0.5 if score == other else score > other)
    return won / pairs if pairs else np.nan


@given(CASES)
def test_it_is_the_share_of_pairs_within_groups(cases: list[tuple[int, bool, int, int]]) -> None:
    columns = np.array(cases, float).reshape(-1, 4).T
    found = concordance(columns[0], columns[1] > 0, columns[2], columns[3])
    assert found == pytest.approx(by_pairs(cases), nan_ok=True)


def test_of_one_group_it_is_mann_whitneys() -> None:
    random = np.random.default_rng(0)
    scores, hits = random.integers(0, 30, 200), random.random(200) < 0.3
    u = mannwhitneyu(scores[hits], scores[~hits]).statistic
    expected = u / (hits.sum() * (~hits).sum())
    assert concordance(scores, hits, np.zeros(200)) == pytest.approx(expected)


def test_samples_are_the_cases_repeated() -> None:
    random = np.random.default_rng(1)
    scores, hits, groups = random.normal(size=40), random.random(40) < 0.4, np.arange(40) % 3
    weights = random.integers(0, 3, (5, 40))
    found = concordance(scores, hits, groups, weights)
    for sample, value in zip(weights, found, strict=True):
        drawn = np.repeat(np.arange(40), sample)
        assert value == pytest.approx(concordance(scores[drawn], hits[drawn], groups[drawn]))


def test_groups_of_their_own_level_do_not_help() -> None:
    # The second group has higher scores and more hits, and within each scores say nothing.
    scores = np.repeat([0.0, 1.0], 50)
    hits = np.r_[np.arange(50) < 5, np.arange(50) < 45]
    assert concordance(scores, hits, np.zeros(100)) > 0.85
    assert concordance(scores, hits, np.repeat([0, 1], 50)) == 0.5
