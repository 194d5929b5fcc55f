"""Scores against the normal distribution, and against a tail that is known."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import special, stats

from avsec_gym.errors import ConfigurationError
from avsec_gym.validation.normal_scores import NormalScores, fit_normal_scores, log_odds


def test_clean_moments_are_normal_whatever_their_shares() -> None:
    random = np.random.default_rng(0)
    clean = np.stack(
        [random.beta(2, 30, 5000), random.uniform(0, 1, 5000), random.pareto(3, 5000) / 50],
        axis=1,
    ).clip(0, 1)
    scores = fit_normal_scores(clean)(clean)
    for column in scores.T:
        assert stats.kstest(column, "norm").statistic < 0.02


def test_what_was_never_seen_is_as_far_out_as_the_tail_says() -> None:
    """Log-odds fall off exponentially: the chance of each point is known."""
    random = np.random.default_rng(1)
    clean = special.expit(random.exponential(0.5, (20000, 1)) - 5.0)
    scale = fit_normal_scores(clean)
    for beyond in (2.0, 4.0, 6.0):
        found = scale(np.array([[special.expit(beyond - 5.0)]]))[0, 0]
        assert found == pytest.approx(stats.norm.isf(np.exp(-beyond / 0.5)), abs=0.15)
    ascending = scale(np.linspace(0, 1, 500)[:, None])[:, 0]
    assert np.isfinite(ascending).all()
    assert (np.diff(ascending) >= 0).all()


def test_shares_that_are_often_equal_are_in_the_middle_of_their_ranks() -> None:
    clean = np.r_[np.zeros(600), np.linspace(0.01, 0.2, 400)][:, None]
    scores = fit_normal_scores(clean)(np.array([[0.0], [0.01], [0.9]]))[:, 0]
    assert scores[0] == pytest.approx(stats.norm.ppf(0.3), abs=0.02)
    assert scores[1] == pytest.approx(stats.norm.ppf(0.6), abs=0.02)
    assert scores[2] > 3
    # Elements that never vary say nothing as long as they do not.
    constant = fit_normal_scores(np.full((50, 1), 0.3))
    assert constant(np.array([[0.3]]))[0, 0] == pytest.approx(0.0, abs=0.01)
    assert constant(np.array([[0.6]]))[0, 0] > 5


def test_without_clean_moments_scores_are_log_odds() -> None:
    shares = np.array([[0.0, 0.5], [1.0, 0.2]])
    scores = NormalScores(np.zeros((0, 2)), np.ones(2))(shares)
    np.testing.assert_array_equal(scores, log_odds(shares))
    np.testing.assert_allclose(scores, [[-9.21, 0.0], [9.21, -1.386]], atol=1e-3)


def test_what_is_no_scale_is_refused() -> None:
    for quantiles, tails in (
        (np.zeros((3, 2)), np.ones(3)),
        (np.zeros(3), np.ones(3)),
        (np.array([[1.0], [0.0]]), np.ones(1)),
        (np.zeros((3, 1)), np.zeros(1)),
        (np.full((3, 1), np.nan), np.ones(1)),
    ):
        with pytest.raises(ConfigurationError):
            NormalScores(quantiles, tails)
