"""The interquartile mean of scores, with bootstrap intervals.

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
    trainings: Sequence[Floats], *, resamples: int = 2000, seed: int = 0
) -> tuple[float, float]:
    """The 95 % percentile interval of the interquartile mean of all scores together.

    The bootstrap draws trainings and tasks, each with replacement, as for
    `probability_of_improvement`: tasks are the same for all trainings, and so are drawn for all
    together.  Of one training only tasks are drawn.

    Args:
        trainings: The scores of each training on T tasks, each of shape (T,).
        resamples: Bootstrap samples.
        seed: Seed of the bootstrap.

    Returns:
        Lower and upper bound; nan, nan without scores.
    """
    scores = np.asarray(trainings, float)
    if scores.size == 0:
        return (math.nan, math.nan)
    generator = np.random.default_rng(seed)
    runs, tasks = (generator.integers(count, size=(resamples, count)) for count in scores.shape)
    drawn = scores[runs[:, :, None], tasks[:, None, :]]
    low, high = np.quantile(interquartile_mean(drawn.reshape(resamples, -1)), [0.025, 0.975])
    return (float(low), float(high))
