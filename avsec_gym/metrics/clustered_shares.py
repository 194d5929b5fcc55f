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
from dataclasses import dataclass, replace
from statistics import NormalDist

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import stdtrit

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
        >>> [round(bound, 3) for bound in share.interval]  # Two clusters show little.
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


def share_of_trainings(hits: ArrayLike) -> Share:
    """How many of how many, of several trainings that were judged in the same situations.

    The interval over situations, which all trainings share, is widened by how much the trainings
    differ: Student's t of their rates, both spreads squared and added.

    Args:
        hits: Shape (T, N): a row for each training, T and N one or more.

    Example:
        >>> alike, unlike = share_of_trainings([[1, 0]] * 3), share_of_trainings([[1, 1], [0, 0]])
        >>> [round(share.interval[0], 3) for share in (alike, unlike)]
        [0.095, 0.0]
    """
    flags = np.asarray(hits, bool)
    trainings, situations = flags.shape
    share = share_of(flags.T, list(map(str, range(situations))))
    if trainings < 2 or share.rate is None or share.interval is None:
        return share
    deviation = float(flags.mean(axis=1).std(ddof=1)) / math.sqrt(trainings)
    spread = float(stdtrit(trainings - 1, 0.975)) * deviation
    low, high = (math.hypot(share.rate - bound, spread) for bound in share.interval)
    return replace(share, interval=(max(0.0, share.rate - low), min(1.0, share.rate + high)))


def difference_of_shares(first: Share, second: Share) -> Estimate:
    """The first less the second, with Newcombe's interval (1998, method 10).

    The two are taken to be of different cases; where they share some, the interval is too wide.

    Args:
        first: A share of one case or more.
        second: The other one.

    Example:
        >>> difference = difference_of_shares(Share.of_counts(56, 70), Share.of_counts(48, 80))
        >>> [round(bound, 4) for bound in difference.interval]  # Newcombe's example (a).
        [0.0524, 0.3339]
    """
    if first.rate is None or second.rate is None or not first.interval or not second.interval:
        return Estimate(None)
    difference = first.rate - second.rate
    (low, high), (least, most) = first.interval, second.interval
    below = math.hypot(first.rate - low, most - second.rate)
    above = math.hypot(high - first.rate, second.rate - least)
    return Estimate(difference, (difference - below, difference + above))


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
        hits: Whether each case is a hit, as of `share_of`, one or more.
        clusters: The cluster of each case, as of `share_of`.

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
