"""Shares of cases, with intervals that know which cases belong together.

Frames of one drive are alike, and so are the attacks on one frame: a hundred cases may hold no more
information than ten.  Such cases are a cluster.  Wilson's interval is widened by the design effect
(Kish 1965): how many times as much the share varies from cluster to cluster as it would if all
cases were independent.  A bootstrap over clusters estimates the same, but cannot doubt what all
clusters have in common: where every case is a hit, its interval is a point.  Here the spread is
taken as if two more clusters had been seen, one all hits and one none: where every case is a hit,
the cases count as many as the clusters.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
from numpy.typing import ArrayLike

from avsec_gym.metrics.estimate import Estimate
from avsec_gym.metrics.intervals import wilson_interval

_Z95 = NormalDist().inv_cdf(0.975)


@dataclass(frozen=True)
class Share:
    """How many of how many.

    Args:
        count: The number of hits.
        of: The number of cases.
        rate: Hits of all cases; None without a case.
        interval: The 95 % interval of the rate, low and high; None without a case.
    """

    count: int
    of: int
    rate: float | None
    interval: tuple[float, float] | None

    @classmethod
    def of_counts(cls, count: int, of: int) -> Share:
        """Cases that do not belong together in clusters: Wilson's interval.

        Example:
            >>> Share.of_counts(0, 0).rate is None
            True
        """
        return cls(count, of, count / of, wilson_interval(count, of)) if of else _NO_CASE

    @property
    def estimate(self) -> Estimate:
        """The rate with its interval."""
        return Estimate(self.rate, self.interval)

    @property
    def percent(self) -> float:
        """The rate in percent; NaN without a case."""
        return math.nan if self.rate is None else 100 * self.rate


_NO_CASE = Share(0, 0, None, None)


def share_of(hits: ArrayLike, clusters: Sequence[str]) -> Share:
    """How many of how many, with an interval that knows of clusters.

    Args:
        hits: Shape (N,), or (N, C) where a row holds all C cases of a frame.
        clusters: Cluster that each row belongs to, such as its drive; N names.

    Example:
        >>> share = share_of([True] * 40, ["first", "second"] * 20)
        >>> [round(bound, 3) for bound in share.interval]  # Two clusters say little.
        [0.342, 1.0]
    """
    if not np.size(hits):
        return _NO_CASE
    flags = np.asarray(hits, bool).reshape(len(clusters), -1)
    count, of = int(flags.sum()), int(flags.size)
    effect = design_effect(flags, clusters)
    return Share(count, of, count / of, clustered_interval(count, of, effect))


def clustered_interval(count: int, of: int, effect: float) -> tuple[float, float]:
    """The 95 % interval of a share whose cases belong together in clusters.

    Args:
        count: The number of hits.
        of: The number of cases.
        effect: The design effect of the clusters, 1 or more; 1 gives Wilson's interval.
    """
    return wilson_interval(count, of, _Z95 * math.sqrt(effect))


def effective_interval(rate: float, independent: float) -> tuple[float, float]:
    """The 95 % interval of a share of weighted cases, which count as so many independent ones.

    Args:
        rate: The share, from 0 to 1.
        independent: The number of independent cases, such as Kish's of weighted clusters.
    """
    return wilson_interval(rate * independent, independent)


def design_effect(hits: ArrayLike, clusters: Sequence[str]) -> float:
    """How many times as much a share varies as that of independent cases would; at least 1.

    Args:
        hits: As of `share_of`, one or more.
        clusters: As of `share_of`.

    Example:
        >>> design_effect([True, True, False, False], ["a", "a", "b", "b"])
        2.0
    """
    flags = np.asarray(hits, bool).reshape(len(clusters), -1)
    _, cluster = np.unique(np.asarray(clusters), return_inverse=True)
    cases = np.bincount(cluster) * float(flags.shape[1])
    found = np.bincount(cluster, flags.sum(axis=1))
    # Two clusters of the usual size beside those seen: one all hits, one none.
    usual = cases.mean()
    cases, found = np.r_[cases, usual, usual], np.r_[found, usual, 0.0]
    rate = found.sum() / cases.sum()
    between = float(((found - rate * cases) ** 2).sum())
    return max(1.0, between / float(rate * (1 - rate) * cases.sum()))
