"""The interquartile mean against scipy, and its interval against every possible resample."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import bootstrap, trim_mean

from avsec_gym.metrics.interquartile_mean import interquartile_interval, interquartile_mean


@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=60))
def test_it_is_scipys_trimmed_mean(scores: list[float]) -> None:
    expected = trim_mean(scores, 0.25)
    assert float(interquartile_mean(np.array(scores))) == pytest.approx(expected, abs=1e-6)


def test_many_rows_are_as_many_means() -> None:
    scores = np.random.default_rng(0).normal(size=(7, 21))
    expected = [trim_mean(row, 0.25) for row in scores]
    assert interquartile_mean(scores).tolist() == pytest.approx(expected)


def test_one_wild_score_changes_nothing() -> None:
    assert float(interquartile_mean(np.array([1.0, 2.0, 3.0, 1e9]))) == 2.5


def test_the_interval_is_that_of_all_resamples() -> None:
    """Two strata of three scores have 27 resamples each: all 729 can be looked at."""
    strata = [np.array([0.0, 0.4, 1.0]), np.array([2.0, 3.0, 7.0])]
    own = [[list(draw) for draw in product(scores, repeat=3)] for scores in strata]
    every = [trim_mean(first + second, 0.25) for first, second in product(*own)]
    found = interquartile_interval(strata, resamples=200_000)
    # Means of so few scores come in steps: the quantile of all of them is one of two neighbours.
    for bound, share in zip(found, (0.025, 0.975), strict=True):
        near = np.quantile(every, [share - 0.003, share + 0.003])
        assert near[0] - 1e-9 <= bound <= near[1] + 1e-9


def test_one_stratum_is_scipys_bootstrap() -> None:
    scores = np.random.default_rng(3).normal(size=40)
    expected = bootstrap(
        (scores,),
        lambda x, axis: trim_mean(x, 0.25, axis=axis),
        method="percentile",
        n_resamples=20_000,
        rng=np.random.default_rng(1),
    ).confidence_interval
    assert interquartile_interval([scores], resamples=20_000) == pytest.approx(expected, abs=0.02)


def test_strata_keep_their_share() -> None:
    """Without strata, some resamples would hold one group alone."""
    low, high = interquartile_interval([np.zeros(10), np.ones(10)])
    assert (low, high) == (0.5, 0.5)


def test_no_scores_no_mean() -> None:
    assert math.isnan(float(interquartile_mean(np.zeros(0))))
    assert all(map(math.isnan, interquartile_interval([])))
