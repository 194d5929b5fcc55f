"""The bootstrap over clusters: figures of a set of cases, and of sets drawn anew from it.

Cases of one scene, drive or frame are alike: whole clusters are drawn, with replacement and with
all their cases (Davison and Hinkley 1997, "Bootstrap methods and their application", section 3.8).
The words of this room for intervals and comparisons, of which pages, reports and commands use
nothing else:

- a share of cases: `avsec_gym.metrics.clustered_shares.share_of`, which needs no draws;
- a ratio of sums, a mean, or any other figure: `ClusterBootstrap.ratio`, `mean_over_clusters`,
  `ClusterBootstrap.statistic`;
- a paired difference, of figures of the same clusters: ``first - second`` of the same draws; of
  episodes: `avsec_gym.metrics.paired`, `avsec_gym.metrics.paired_scores`;
- a difference of two sets that share no cluster, such as two parts of the assets:
  `difference_of_parts`;
- a rank correlation of two figures over several things: `sampled_rank_correlation`;
- many comparisons at once: `avsec_gym.metrics.many_comparisons`;
- a threshold that was set at few samples: `avsec_gym.metrics.tolerance`.

An interval over scenes is one of these assets, detectors and attacks: it holds for other scenes of
the same making, and knows nothing of assets that no scene shows.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from statistics import NormalDist

import numpy as np
from numpy.typing import ArrayLike

from avsec_gym.geometry import Floats, Integers
from avsec_gym.metrics.estimate import Estimate

LOW_AND_HIGH = (0.025, 0.975)
"""Levels of samples at which a 95 % percentile interval ends."""
_FEWEST_RANKED = 3
"""Fewer things have no order worth a correlation."""


@dataclass(frozen=True, eq=False)
class Sampled:
    """A figure, and its values in bootstrap samples.

    Figures of the same draws of the same clusters can be subtracted, sample by sample.

    Args:
        value: The figure.
        samples: The value in each sample, shape (R,); NaN where a sample has nothing to measure.
    """

    value: float
    samples: Floats

    def __sub__(self, other: Sampled) -> Sampled:
        """The paired difference; of figures that share no cluster see `difference_of_parts`."""
        return Sampled(self.value - other.value, self.samples - other.samples)

    def scaled(self, factor: float) -> Sampled:
        """The same in another unit, such as percent.

        Args:
            factor: What the figure is multiplied by.
        """
        return Sampled(factor * self.value, factor * self.samples)

    @property
    def estimate(self) -> Estimate:
        """The figure with its interval; no value where there is nothing to measure."""
        return Estimate(float(self.value) if np.isfinite(self.value) else None, self.interval)

    @property
    def interval(self) -> list[float] | None:
        """95 %, low and high; None where no sample has a value."""
        known = self.samples[np.isfinite(self.samples)]
        return [float(q) for q in np.quantile(known, LOW_AND_HIGH)] if len(known) else None

    @property
    def interval_around(self) -> list[float] | None:
        """`interval`, widened to hold the figure itself.

        Drawing adds noise, which lowers correlations: one near 1 may lie above nearly all draws.
        """
        interval = self.interval
        return interval and [min(interval[0], self.value), max(interval[1], self.value)]

    @property
    def p(self) -> float:
        """Two-sided p-value of the figure's being zero.

        By the normal distribution, with the spread of the samples: of a thousand draws none is
        below 0.001 otherwise, and corrections for many comparisons need smaller ones.  NaN where
        fewer than two samples are known.
        """
        known = self.samples[np.isfinite(self.samples)]
        if len(known) < 2 or not np.isfinite(self.value):
            return np.nan
        spread = float(known.std(ddof=1))
        if spread == 0:
            return 1.0 if self.value == 0 else 0.0
        return 2 * NormalDist().cdf(-abs(self.value) / spread)


@dataclass(frozen=True)
class ClusterBootstrap:
    """Draws of clusters, which all figures of one comparison share.

    Args:
        clusters: Number of clusters, C; of fewer than two nothing can be drawn, and no figure has
            an interval.
        resamples: Number of samples, R.
        seed: Seed of the draws.

    Example:
        >>> scenes = ClusterBootstrap(4, resamples=1000)
        >>> scenes.ratio([0, 1, 2, 1], [2, 2, 2, 2]).value
        0.5
    """

    clusters: int
    resamples: int
    seed: int = 0

    @cached_property
    def draws(self) -> Integers:
        """How often each sample draws each cluster, shape (R, C)."""
        return draw_resamples(self.clusters, self.resamples, self.seed)

    def ratio(self, part: ArrayLike, whole: ArrayLike) -> Sampled:
        """The ratio of two sums over clusters, such as hits of cases.

        Args:
            part: The sum of each cluster, shape (C,).
            whole: The same of what it is divided by.
        """
        parts, wholes = np.asarray(part, float), np.asarray(whole, float)

        def of(weights: Integers) -> Floats:
            with np.errstate(invalid="ignore", divide="ignore"):
                return np.asarray((weights @ parts) / (weights @ wholes))

        return self.statistic(of)

    def statistic(self, of: Callable[[Integers], Floats]) -> Sampled:
        """Any figure of the set.

        Args:
            of: The figure of K sets, shape (K,), from how often each counts each cluster, shape
                (K, C).
        """
        value = float(of(np.ones((1, self.clusters), np.int64))[0])
        if self.clusters < 2:
            return Sampled(value, np.full(self.resamples, np.nan))
        return Sampled(value, of(self.draws))


def mean_over_clusters(
    values: ArrayLike, clusters: Sequence[str], *, resamples: int, seed: int = 0
) -> Sampled:
    """The mean of cases, some of which belong together; without an interval of one cluster.

    Args:
        values: A value of each case, shape (N,), N one or more.
        clusters: The cluster of each case; N names.
        resamples: Number of bootstrap samples.
        seed: Seed of the bootstrap.

    Example:
        >>> mean_over_clusters([1.0, 2.0, 6.0], ["a", "a", "b"], resamples=100).value
        3.0
    """
    _, cluster = np.unique(np.asarray(clusters), return_inverse=True)
    counts = np.bincount(cluster)
    sums = np.bincount(cluster, np.asarray(values, float))
    return ClusterBootstrap(len(counts), resamples, seed).ratio(sums, counts)


def difference_of_parts(first: Sampled, second: Sampled, *, seed: int = 0) -> Sampled:
    """The first less the second, of two sets that share no cluster.

    Such sets are the scenes of two parts of the assets: each figure has its own interval over
    scenes, and their difference one of both together, which shows whether the parts differ by more
    than scenes do.  The samples of the second are shuffled: those of two sets of one size are
    drawn alike, and would pair scenes that have nothing to do with each other.

    Args:
        first: The figure of one set.
        second: The figure of the other one, of as many samples.
        seed: Seed of the shuffle.

    Example:
        >>> one, other = (ClusterBootstrap(2, 50).ratio(hits, [4, 4]) for hits in ([3, 3], [1, 2]))
        >>> difference_of_parts(one, other).value
        0.375
    """
    return first - Sampled(second.value, np.random.default_rng(seed).permutation(second.samples))


def sampled_rank_correlation(pairs: Sequence[tuple[Sampled, Sampled]]) -> Sampled | None:
    """Spearman's correlation of two figures of several things, in each sample.

    Args:
        pairs: The two figures of each thing, all of the same draws.

    Returns:
        The correlation; None for fewer than three things, or where one figure never varies.
    """
    if len(pairs) < _FEWEST_RANKED:
        return None
    drawn = np.array([[figure.samples for figure in pair] for pair in pairs])  # (things, 2, R)
    rho = float(_spearman(np.array([[[figure.value] for figure in pair] for pair in pairs]))[0])
    return Sampled(rho, _spearman(drawn)) if np.isfinite(rho) else None


def draw_resamples(clusters: int, count: int, seed: int) -> Integers:
    """How often each cluster is drawn, with replacement, shape (count, clusters)."""
    generator = np.random.default_rng(seed)
    drawn = generator.integers(0, clusters, (count, clusters))
    return np.stack([np.bincount(row, minlength=clusters) for row in drawn])


def _spearman(pairs: Floats) -> Floats:
    """Of pairs of shape (n, 2, R), shape (R,); NaN where one of the two does not vary."""
    # Here, since it takes as long to load as all else that rates need.
    from scipy.stats import rankdata

    ranks = rankdata(pairs, axis=0) - (len(pairs) + 1) / 2
    spread = np.sqrt((ranks**2).sum(axis=0))
    with np.errstate(invalid="ignore"):
        return np.asarray((ranks[:, 0] * ranks[:, 1]).sum(axis=0) / (spread[0] * spread[1]))
