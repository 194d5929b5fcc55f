"""ROC curves of scores, and the area below them with an interval that knows of clusters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.metrics.average_precision_curves import draw_resamples

_LOW_AND_HIGH = (0.025, 0.975)


@dataclass(frozen=True, eq=False)
class ClusteredScores:
    """Scores of cases, some of which belong together.

    Args:
        scores: How much speaks for a positive, shape (N,); -inf where nothing is said.
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
    low, high = np.quantile(areas, _LOW_AND_HIGH)
    return RocArea(float(wins.mean()), (float(low), float(high)))
