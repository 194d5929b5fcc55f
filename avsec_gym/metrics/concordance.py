"""How well a score tells cases apart: the area under the ROC curve, within groups of cases.

The area is the probability that a case of one kind has a higher score than one of the other kind
(Hanley and McNeil 1982, "The meaning and use of the area under a ROC curve"), equal scores counting
half.  Cases of different groups, such as attacks of different strength, need not be comparable:
only pairs within a group count.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from avsec_gym.geometry import Floats


def concordance(
    scores: ArrayLike, hits: ArrayLike, groups: ArrayLike, weights: ArrayLike | None = None
) -> Floats:
    """The share of pairs of a hit and a miss in which the hit has the higher score.

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
