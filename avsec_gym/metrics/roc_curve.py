"""ROC curves of scores, and the area below them with an interval that knows of clusters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from avsec_gym.geometry import Floats
from avsec_gym.metrics.cluster_bootstrap import LOW_AND_HIGH, draw_resamples


@dataclass(frozen=True, eq=False)
class ClusteredScores:
    """Scores of cases, some of which belong together.

    Args:
        scores: How much speaks for a positive, shape (N,); -inf where nothing does.
        clusters: Cluster of each case, such as the instant that it is of; N names.
    """

    scores: Floats
    clusters: Sequence[str]

    def __len__(self) -> int:
        return len(self.scores)


@dataclass(frozen=True)
class RocArea:
    """The area under a ROC curve.

    Args:
        value: The chance that a positive has a higher score than a negative, ties for a half; None
            without either.
        interval: 95 %, by a bootstrap over clusters; None below two clusters.  Where all positives
            are above all negatives it is a point.
    """

    value: float | None
    interval: tuple[float, float] | None


def threshold_at(negatives: Floats, rate: float) -> float:
    """The score that at most a share of the negatives exceeds; an order statistic.

    Args:
        negatives: Scores of negatives, shape (N,).
        rate: The share, from 0 to 1.

    Returns:
        -inf where all may exceed it; what has no score, -inf, still does not. With no negatives
        it is inf: nothing exceeds it.

    Example:
        >>> threshold_at(np.arange(10.0), 0.2)
        7.0
    """
    ordered = np.sort(negatives)
    # A product such as 0.29 * 100 comes out just below the whole number that is meant.
    beyond = int(rate * len(ordered) + 1e-9)
    if not len(ordered):
        return np.inf
    return -np.inf if beyond >= len(ordered) else float(ordered[len(ordered) - 1 - beyond])


def roc_curve(positives: Floats, negatives: Floats) -> tuple[Floats, Floats]:
    """False and true positive rates of all thresholds, from (0, 0) on, both shape (T,).

    Cases without a score, -inf, are never taken for positive: the curve ends where they begin.

    Args:
        positives: Scores of positives, shape (P,), one or more.
        negatives: Scores of negatives, shape (N,), one or more.

    Example:
        >>> roc_curve(np.array([3.0, 1.0]), np.array([2.0, 0.0]))[1].tolist()
        [0.0, 0.5, 0.5, 1.0, 1.0]
    """
    thresholds = np.unique(np.r_[positives, negatives])
    thresholds = np.r_[np.inf, thresholds[np.isfinite(thresholds)][::-1]]
    false, true = (
        (len(scores) - np.searchsorted(np.sort(scores), thresholds)) / len(scores)
        for scores in (negatives, positives)
    )
    return np.asarray(false), np.asarray(true)


def roc_area(
    positives: ClusteredScores, negatives: ClusteredScores, *, resamples: int = 2000, seed: int = 0
) -> RocArea:
    """The area under the ROC curve (Hanley and McNeil 1982).

    Args:
        positives: Scores of positives.
        negatives: Scores of negatives; clusters of the same name are drawn together.
        resamples: Number of bootstrap samples.
        seed: The seed of the bootstrap.

    Example:
        >>> two = ["first", "second"]
        >>> above, below = np.array([3.0, 1.0]), np.array([2.0, 0.0])
        >>> roc_area(ClusteredScores(above, two), ClusteredScores(below, two)).value
        0.75
    """
    if not len(positives) or not len(negatives):
        return RocArea(None, None)
    names, cluster = np.unique([*positives.clusters, *negatives.clusters], return_inverse=True)
    of_positive, of_negative = np.split(cluster, [len(positives)])
    # How often positives of each cluster are above negatives of each cluster.
    ahead = positives.scores[:, None] > negatives.scores
    wins = ahead + 0.5 * (positives.scores[:, None] == negatives.scores)
    by_cluster = np.zeros((len(names), len(names)))
    np.add.at(by_cluster, (of_positive[:, None], of_negative[None]), wins)
    if len(names) < 2:
        return RocArea(float(wins.mean()), None)
    drawn = draw_resamples(len(names), resamples, seed)
    above = np.einsum("ri,ij,rj->r", drawn, by_cluster, drawn, optimize=True)
    counts = [
        drawn @ np.bincount(each, minlength=len(names)) for each in (of_positive, of_negative)
    ]
    pairs = counts[0] * counts[1]
    areas = above[pairs > 0] / pairs[pairs > 0]
    low, high = np.quantile(areas, LOW_AND_HIGH)
    return RocArea(float(wins.mean()), (float(low), float(high)))


def concordance(
    scores: ArrayLike, hits: ArrayLike, groups: ArrayLike, weights: ArrayLike | None = None
) -> Floats:
    """The area under the ROC curve of cases in groups, of which only pairs within one count.

    It is the share of pairs of a hit and a miss in which the hit has the higher score, equal scores
    counting half.  Cases of different groups, such as attacks of different strength, need not be
    comparable.

    Args:
        scores: Shape (N,), finite.
        hits: Whether each case is a hit, shape (N,).
        groups: The group of each case, shape (N,): pairs across groups do not count.
        weights: How often each case counts, shape (N,) or (R, N), such as in R bootstrap samples;
            None: once.

    Returns:
        From 0 to 1, shape () or (R,); NaN where there is no pair.

    Example:
        >>> concordance([1, 2, 3, 3], [False, True, False, True], [0, 0, 0, 0])
        array(0.625)
    """
    score, hit = np.asarray(scores, float), np.asarray(hits, bool)
    weight = np.ones(len(score)) if weights is None else np.asarray(weights, float)
    pairs, won = np.zeros(weight.shape[:-1]), np.zeros(weight.shape[:-1])
    group = np.asarray(groups)
    for each in np.unique(group):
        own = np.flatnonzero(group == each)
        more, better = _pairs(score[own], hit[own], weight[..., own])
        pairs, won = pairs + more, won + better
    with np.errstate(invalid="ignore"):
        return np.asarray(won / pairs)


def _pairs(scores: Floats, hits: NDArray[np.bool_], weights: Floats) -> tuple[Floats, Floats]:
    """Weighted number of pairs, and of those in which the hit is above; ties count half."""
    order = np.argsort(scores, kind="stable")
    known = scores[order]
    # The first case of each score; a group has one or more.
    first = np.flatnonzero(np.r_[True, known[1:] != known[:-1]])
    ordered, hit = weights[..., order], hits[order]
    # Of each score: the weight of hits and of misses.
    hit_weight = np.add.reduceat(ordered * hit, first, axis=-1)
    miss_weight = np.add.reduceat(ordered * ~hit, first, axis=-1)
    below = np.cumsum(miss_weight, axis=-1) - 0.5 * miss_weight
    pairs = hit_weight.sum(axis=-1) * miss_weight.sum(axis=-1)
    return pairs, (hit_weight * below).sum(axis=-1)
