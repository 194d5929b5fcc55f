"""Paired differences against scipy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import binomtest, bootstrap

from avsec_gym.metrics.paired_scores import paired_difference


def test_it_is_scipys_paired_bootstrap() -> None:
    generator = np.random.default_rng(0)
    first, second = generator.random(120) < 0.6, generator.random(120) < 0.4
    found = paired_difference(first, second)
    expected = bootstrap(
        (first.astype(float), second.astype(float)),
        lambda a, b, axis: a.mean(axis=axis) - b.mean(axis=axis),
        paired=True,
        method="percentile",
        n_resamples=10_000,
        rng=np.random.default_rng(1),
    ).confidence_interval
    assert found.difference == pytest.approx(first.mean() - second.mean())
    assert found.interval == pytest.approx(expected, abs=0.012)
    lost, gained = int((second & ~first).sum()), int((first & ~second).sum())
    assert found.p == pytest.approx(binomtest(lost, lost + gained).pvalue)


def test_equal_agents_differ_by_nothing() -> None:
    won = np.arange(50) % 3 == 0
    assert paired_difference(won, won).interval == (0.0, 0.0)
    assert paired_difference(won, ~won).difference == pytest.approx(2 * won.mean() - 1)
