"""Tolerance bounds of order statistics against scipy's beta and binomial laws, and by drawing."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import beta, binom

from avsec_gym.errors import ConfigurationError
from avsec_gym.metrics.tolerance import (
    fewest_samples,
    largest_above,
    rate_bound,
    tolerance_threshold,
)

COUNTS = st.integers(1, 3000).flatmap(lambda n: st.tuples(st.just(n), st.integers(0, n - 1)))
RATES = st.sampled_from([0.001, 0.01, 0.03, 0.1, 0.5])
CONFIDENCES = st.sampled_from([0.5, 0.9, 0.95, 0.99])


@given(COUNTS, CONFIDENCES)
def test_the_bound_is_the_quantile_of_the_beta_law(
    counts: tuple[int, int], confidence: float
) -> None:
    n, k = counts
    assert rate_bound(n, k, confidence) == pytest.approx(beta.ppf(confidence, k + 1, n - k))
    assert k / n < rate_bound(n, k, 0.95) < rate_bound(n, k + 1, 0.95) <= 1


@given(st.integers(1, 3000), RATES, CONFIDENCES)
def test_one_sample_more_above_keeps_the_rate_no_longer(
    n: int, rate: float, confidence: float
) -> None:
    k = largest_above(n, rate, confidence)
    if k is not None:
        assert beta.ppf(confidence, k + 1, n - k) <= rate + 1e-12
    following = 0 if k is None else k + 1
    assert following == n or beta.ppf(confidence, following + 1, n - following) > rate - 1e-12


@given(RATES, st.integers(0, 40), CONFIDENCES)
def test_one_sample_fewer_does_not_keep_the_rate(rate: float, k: int, confidence: float) -> None:
    n = fewest_samples(rate, k, confidence)
    assert binom.cdf(k, n, rate) <= (1 - confidence) * (1 + 1e-9)
    assert n == k + 1 or binom.cdf(k, n - 1, rate) > (1 - confidence) * (1 - 1e-9)
    assert largest_above(n, rate, confidence) == k


def test_thresholds_of_drawn_samples_keep_the_bound_as_often_as_promised() -> None:
    random, n, k = np.random.default_rng(0), 60, 2
    # Uniform samples: the share above a threshold is 1 less the threshold.
    thresholds = np.sort(random.random((20_000, n)), axis=1)[:, n - 1 - k]
    kept = (1 - thresholds <= rate_bound(n, k)).mean()
    # 20,000 draws miss 95 % by three times 0.15 % at most.
    assert kept == pytest.approx(0.95, abs=0.005)
    # The share of the samples themselves promises too much in more than half of the draws.
    assert (1 - thresholds <= k / n).mean() < 0.5


def test_the_largest_of_few_samples_vouches_for_what_is_known_of_zero_hits() -> None:
    # No hit among n: 1 - 0.05 ** (1 / n), about three in n.
    for n in (1, 20, 300):
        assert rate_bound(n, 0) == pytest.approx(1 - 0.05 ** (1 / n))
    assert rate_bound(5, 5) == 1


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: rate_bound(0, 0),
        lambda: rate_bound(10, 11),
        lambda: rate_bound(10, -1),
        lambda: rate_bound(10, 1, 1.0),
        lambda: largest_above(10, 0.0),
        lambda: fewest_samples(1.0),
        lambda: fewest_samples(1e-12),
        lambda: fewest_samples(0.1, -1),
    ],
)
def test_what_cannot_be_is_refused(wrong) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(ConfigurationError):
        wrong()


@pytest.mark.parametrize(("clusters", "above"), [(8, 0), (298, 0), (299, 0), (473, 1), (1000, 4)])
def test_a_threshold_counts_clusters_by_their_largest_value(clusters: int, above: int) -> None:
    rng = np.random.default_rng(0)
    values, names = rng.random((clusters, 3)), [str(i // 3) for i in range(3 * clusters)]
    found = tolerance_threshold(values.ravel(), names, 0.01)
    assert found.value == np.sort(values.max(axis=1))[clusters - 1 - above]
    assert (found.clusters, found.above, found.fewest) == (clusters, above, 299)
    assert found.vouched == pytest.approx(beta.ppf(0.95, above + 1, clusters - above))
    assert (found.vouched <= 0.01) == (clusters >= 299)


def test_a_threshold_of_equal_values_vouches_for_more() -> None:
    found = tolerance_threshold([0.5] * 473, [str(i) for i in range(473)], 0.01)
    assert (found.value, found.above) == (0.5, 0)
    with pytest.raises(ConfigurationError):
        tolerance_threshold([], [], 0.01)


def test_a_tolerance_threshold_keeps_its_rate_in_nineteen_of_twenty_draws() -> None:
    rng = np.random.default_rng(1)
    names = [str(i) for i in range(120)]
    kept = [1 - tolerance_threshold(rng.random(120), names, 0.05).value <= 0.05 for _ in range(400)]
    assert np.mean(kept) > 0.92
