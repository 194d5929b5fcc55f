"""The interquartile mean of scores, with stratified bootstrap intervals.

R. Agarwal et al., "Deep reinforcement learning at the edge of the statistical precipice", NeurIPS
2021: between a mean, which a few scores decide, and a median, which looks at one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from avsec_gym.geometry import Floats


def interquartile_mean(scores: Floats) -> Floats:
    """The mean of the middle half: a quarter of the scores is cut off at each end, rounded down.

    Args:
        scores: Shape (..., N).

    Returns:
        Shape (...); nan without scores.

    Example:
        >>> float(interquartile_mean(np.array([0.0, 1.0, 3.0, 100.0])))
        2.0
    """
    ordered = np.sort(np.asarray(scores, float), axis=-1)
    count = ordered.shape[-1]
    if count == 0:
        return np.full(ordered.shape[:-1], math.nan)
    cut = count // 4
    return np.asarray(ordered[..., cut : count - cut].mean(axis=-1))


def interquartile_interval(
    strata: Sequence[Floats], *, resamples: int = 2000, seed: int = 0
) -> tuple[float, float]:
    """The 95 % percentile interval of the interquartile mean of all scores together.

    The bootstrap draws as many scores of each stratum as it has, so that every training, or every
    task, keeps its share.

    Args:
        strata: Scores of each stratum, each of shape (N,).
        resamples: Bootstrap samples.
        seed: Seed of the bootstrap.

    Returns:
        Lower and upper bound; nan, nan without scores.
    """
    filled = [np.asarray(scores, float) for scores in strata if len(scores)]
    if not filled:
        return (math.nan, math.nan)
    generator = np.random.default_rng(seed)
    drawn = [
        scores[generator.integers(len(scores), size=(resamples, len(scores)))] for scores in filled
    ]
    means = interquartile_mean(np.concatenate(drawn, axis=1))
    low, high = np.quantile(means, [0.025, 0.975])
    return (float(low), float(high))
