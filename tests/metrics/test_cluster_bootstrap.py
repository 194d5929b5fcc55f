"""The bootstrap over clusters: against scipy, against all samples there are, and against truth."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from scipy.stats import bootstrap, spearmanr

from avsec_gym.metrics.cluster_bootstrap import (
    ClusterBootstrap,
    Sampled,
    difference_of_parts,
    draw_resamples,
    mean_over_clusters,
    sampled_rank_correlation,
)


def alike(clusters: int, cases: int, seed: int) -> tuple[np.ndarray, list[str]]:
    """Values around 0, most of whose spread is from cluster to cluster."""
    random = np.random.default_rng(seed)
    own = random.normal(size=clusters).repeat(cases)
    names = [str(number) for number in range(clusters) for _ in range(cases)]
    return own + 0.3 * random.normal(size=clusters * cases), names


def test_a_ratio_has_scipys_interval() -> None:
    random = np.random.default_rng(0)
    whole = random.integers(1, 6, 40)
    part = random.binomial(whole, 0.6)
    found = ClusterBootstrap(40, 5000).ratio(part, whole)
    expected = bootstrap(
        (part, whole),
        lambda a, b, axis: a.sum(axis=axis) / b.sum(axis=axis),
        paired=True,
        method="percentile",
        n_resamples=5000,
        rng=np.random.default_rng(1),
    ).confidence_interval
    assert found.value == part.sum() / whole.sum()
    assert found.interval == pytest.approx([*expected], abs=0.01)


def test_samples_are_those_of_all_that_can_be_drawn() -> None:
    """Of three clusters there are 27 samples, each as likely as the others."""
    part, whole = np.array([0, 2, 5]), np.array([1, 4, 6])
    every = [part[[*drawn]].sum() / whole[[*drawn]].sum() for drawn in product(range(3), repeat=3)]
    found = ClusterBootstrap(3, 20_000).ratio(part, whole).samples
    values, counts = np.unique(found.round(12), return_counts=True)
    expected, times = np.unique(np.round(every, 12), return_counts=True)
    np.testing.assert_allclose(values, expected)
    np.testing.assert_allclose(counts / 20_000, times / 27, atol=0.015)


def test_any_statistic_is_that_of_the_cases_drawn() -> None:
    random = np.random.default_rng(3)
    values, cluster = random.normal(size=30), np.arange(30) % 10

    def mean_square(weights: np.ndarray) -> np.ndarray:
        own = weights[:, cluster]
        return (own @ values**2) / own.sum(axis=1)

    drawn = ClusterBootstrap(10, 50, seed=4)
    found = drawn.statistic(mean_square)
    assert found.value == pytest.approx((values**2).mean())
    for times, sample in zip(draw_resamples(10, 50, 4), found.samples, strict=True):
        cases = np.concatenate([np.flatnonzero(cluster == c) for c in np.repeat(range(10), times)])
        assert sample == pytest.approx((values[cases] ** 2).mean())


def test_means_of_alike_cases_cover_the_truth_only_by_clusters() -> None:
    """The true mean is 0; cases that are taken for independent promise too much."""
    held = np.zeros(2)
    for trial in range(300):
        values, names = alike(25, 8, trial)
        for way, clusters in enumerate((names, list(map(str, range(200))))):
            mean = mean_over_clusters(values, clusters, resamples=400, seed=trial)
            low, high = mean.interval or (0.0, 0.0)
            held[way] += low <= 0 <= high
    by_cluster, by_case = held / 300
    # A percentile interval of 25 clusters falls a little short of 95 %.
    assert 0.90 <= by_cluster <= 0.97
    assert by_case < 0.65


def test_equal_means_of_unequal_clusters_are_weighted_by_cases() -> None:
    mean = mean_over_clusters([1.0, 1.0, 4.0], ["a", "a", "b"], resamples=2000)
    assert mean.value == 2.0
    assert sorted(set(mean.samples)) == [1.0, 2.0, 4.0]
    assert (mean.samples == 2.0).mean() == pytest.approx(0.5, abs=0.04)


def test_one_cluster_alone_has_no_interval() -> None:
    drawn = ClusterBootstrap(1, 20)
    one = drawn.ratio([3], [4])
    assert (one.value, one.interval, one.interval_around) == (0.75, None, None)
    assert np.isnan(one.p)
    assert mean_over_clusters([1.0, 2.0], ["a", "a"], resamples=20).interval is None
    nothing = drawn.ratio([0], [0])
    assert (nothing.estimate.value, nothing.estimate.interval) == (None, None)


def test_what_is_paired_differs_by_less() -> None:
    """Two figures of the same clusters: what both have in common goes out of the difference."""
    random = np.random.default_rng(5)
    common = random.normal(size=200)
    drawn = ClusterBootstrap(200, 2000)
    first, second = (
        drawn.ratio(common + 0.1 * random.normal(size=200), np.ones(200)) for _ in range(2)
    )
    paired, apart = first - second, difference_of_parts(first, second)
    assert paired.value == apart.value == first.value - second.value
    assert paired.samples.std() == pytest.approx(np.sqrt(2 * 0.1**2 / 200), rel=0.15)
    assert apart.samples.std() == pytest.approx(np.sqrt(2 * 1.01 / 200), rel=0.15)


def test_parts_of_one_size_and_seed_are_not_paired() -> None:
    """What is the same by chance, scene by scene, does not narrow the difference of two parts."""
    hits = np.arange(50) % 2
    one, other = (ClusterBootstrap(50, 4000).ratio(hits, np.ones(50)) for _ in range(2))
    assert (one - other).interval == [0.0, 0.0]
    low, high = difference_of_parts(one, other).interval or (0.0, 0.0)
    # Newcombe's and Wald's intervals agree here: both parts have 25 of 50.
    assert (low, high) == pytest.approx((-0.196, 0.196), abs=0.03)


def test_the_difference_of_two_parts_covers_the_truth() -> None:
    random, held = np.random.default_rng(6), 0
    for trial in range(300):
        parts = []
        for clusters, rate in ((60, 0.7), (30, 0.5)):
            own = random.beta(4 * rate, 4 * (1 - rate), clusters)
            hits = random.binomial(5, own)
            parts.append(ClusterBootstrap(clusters, 500, trial).ratio(hits, np.full(clusters, 5)))
        low, high = difference_of_parts(*parts, seed=trial).interval or (0.0, 0.0)
        held += low <= 0.2 <= high
    assert 0.90 <= held / 300 <= 0.98


def test_a_rank_correlation_is_scipys_in_each_sample() -> None:
    random = np.random.default_rng(7)
    drawn = ClusterBootstrap(30, 40)
    pairs = [
        tuple(drawn.ratio(random.binomial(5, rate, 30), np.full(30, 5)) for _ in range(2))
        for rate in (0.2, 0.3, 0.5, 0.8)
    ]
    found = sampled_rank_correlation(pairs)  # type: ignore[arg-type]
    assert found is not None
    assert found.value == pytest.approx(spearmanr(*np.array(values(pairs)).T).statistic)
    for number in range(40):
        expected = spearmanr(*np.array(values(pairs, number)).T).statistic
        assert found.samples[number] == pytest.approx(expected, nan_ok=True)


def values(pairs: list[tuple[Sampled, ...]], sample: int | None = None) -> list[list[float]]:
    return [
        [figure.value if sample is None else figure.samples[sample] for figure in pair]
        for pair in pairs
    ]


def test_too_few_things_and_equal_ones_have_no_order() -> None:
    one, other = (Sampled(value, np.full(9, value)) for value in (1.0, 2.0))
    assert sampled_rank_correlation([(one, one), (other, other)]) is None
    assert sampled_rank_correlation([(one, other), (one, one), (one, other)]) is None


def test_another_unit_scales_figure_and_samples() -> None:
    share = ClusterBootstrap(4, 30).ratio([1, 0, 2, 1], [2, 2, 2, 2])
    percent = share.scaled(100)
    assert percent.value == 50
    np.testing.assert_allclose(percent.samples, 100 * share.samples)
    assert percent.interval == pytest.approx([100 * bound for bound in share.interval or ()])
