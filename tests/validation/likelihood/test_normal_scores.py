"""Scores against the normal distribution, and against a tail that is known."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import special, stats

from avsec_gym.errors import ConfigurationError
from avsec_gym.validation.likelihood.normal_scores import NormalScores, fit_normal_scores, log_odds


def test_clean_frames_are_normal_whatever_their_shares() -> None:
    random = np.random.default_rng(0)
    clean = np.stack(
        [random.beta(2, 30, 5000), random.uniform(0, 1, 5000), random.pareto(3, 5000) / 20 + 0.01],
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
    assert constant(np.array([[0.6]]))[0, 0] > 2.5


def test_without_clean_frames_scores_are_log_odds() -> None:
    shares = np.array([[0.0, 0.5], [1.0, 0.2]])
    scores = NormalScores.plain(2)(shares)
    np.testing.assert_array_equal(scores, log_odds(shares))
    np.testing.assert_allclose(scores, [[-8.111, 0.0], [8.111, -1.386]], atol=1e-3)


@pytest.mark.parametrize("zeros", [0.92, 0.95, 0.99])
def test_where_nearly_all_are_nothing_a_little_is_no_attack(zeros: float) -> None:
    """Single scan points in a window of 96 pixels, now and then."""
    random = np.random.default_rng(0)
    clean = np.where(random.random(4000) < zeros, 0, random.geometric(0.5, 4000)) / 96**2
    scores = fit_normal_scores(clean[:2000, None])(clean[2000:, None])
    assert scores.max() < 4
    never = fit_normal_scores(np.zeros((1000, 1)))(np.array([[0.0], [5 / 96**2], [0.05]]))[:, 0]
    assert never[0] < never[1] < 3.5
    assert never[2] > 5


def test_what_is_no_scale_is_refused() -> None:
    one = np.ones(1)
    for quantiles, begins, chances, tails in (
        (np.zeros((3, 2)), np.ones(3), np.ones(3), np.ones(3)),
        (np.zeros(3), np.ones(3), np.ones(3), np.ones(3)),
        (np.zeros((3, 1)), np.ones(2), one, one),
        (np.array([[1.0], [0.0]]), one, one, one),
        (np.zeros((3, 1)), one, one, 0 * one),
        (np.zeros((3, 1)), one, 0 * one, one),
        (np.full((3, 1), np.nan), one, one, one),
    ):
        with pytest.raises(ConfigurationError):
            NormalScores(quantiles, begins, chances, tails)
