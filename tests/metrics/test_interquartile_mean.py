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
    """Two trainings have four resamples, their three tasks 27: all 108 can be looked at."""
    scores = np.array([[0.0, 0.4, 1.0], [2.0, 3.0, 7.0]])
    every = [
        trim_mean(scores[list(runs)][:, list(tasks)].ravel(), 0.25)
        for runs, tasks in product(product(range(2), repeat=2), product(range(3), repeat=3))
    ]
    found = interquartile_interval(list(scores), resamples=200_000)
    # Means of so few scores come in steps: the quantile of all of them is one of two neighbours.
    for bound, share in zip(found, (0.025, 0.975), strict=True):
        near = np.quantile(every, [share - 0.003, share + 0.003])
        assert near[0] - 1e-9 <= bound <= near[1] + 1e-9


def test_one_training_is_scipys_bootstrap() -> None:
    scores = np.random.default_rng(3).normal(size=40)
    expected = bootstrap(
        (scores,),
        lambda x, axis: trim_mean(x, 0.25, axis=axis),
        method="percentile",
        n_resamples=20_000,
        rng=np.random.default_rng(1),
    ).confidence_interval
    assert interquartile_interval([scores], resamples=20_000) == pytest.approx(expected, abs=0.02)


def test_trainings_that_differ_make_it_wide() -> None:
    """Each of them alone scores the same on all tasks."""
    low, high = interquartile_interval([np.zeros(10), np.ones(10)])
    assert (low, high) == (0.0, 1.0)


def test_no_scores_no_mean() -> None:
    assert math.isnan(float(interquartile_mean(np.zeros(0))))
    assert all(map(math.isnan, interquartile_interval([])))
