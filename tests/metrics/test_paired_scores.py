"""Paired differences against scipy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import binomtest, bootstrap

from avsec_gym.metrics.paired_scores import paired_difference


def test_it_is_scipys_paired_bootstrap() -> None:
    generator = np.random.default_rng(0)
    first, second = generator.random(120) < 0.6, generator.random(120) < 0.4
    found = paired_difference(first, second, list(map(str, range(120))))
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
    won, scenes = np.arange(50) % 3 == 0, list(map(str, range(50)))
    assert paired_difference(won, won, scenes).interval == (0.0, 0.0)
    assert paired_difference(won, ~won, scenes).difference == pytest.approx(2 * won.mean() - 1)


def test_episodes_of_one_scene_are_drawn_together() -> None:
    generator = np.random.default_rng(2)
    first, second = generator.random(60) < 0.6, generator.random(60) < 0.3
    alone = paired_difference(first, second, list(map(str, range(60))))
    four = [np.repeat(flags, 4) for flags in (first, second)]
    together = paired_difference(*four, [str(number // 4) for number in range(240)])
    assert together.difference == pytest.approx(alone.difference)
    assert together.interval == pytest.approx(alone.interval, abs=0.01)
    assert (together.p, alone.p is None) == (None, False)
    assert paired_difference(*four, ["one"] * 240).interval is None
