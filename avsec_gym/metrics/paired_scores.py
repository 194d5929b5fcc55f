"""Two agents in the same episodes: how much more often one reaches its aim."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.metrics.intervals import mcnemar_p


@dataclass(frozen=True)
class PairedDifference:
    """Success of the first less that of the second.

    Args:
        difference: The difference of the rates.
        interval: 95 % percentile interval of a bootstrap that draws episodes.
        p: McNemar's exact test.
    """

    difference: float
    interval: tuple[float, float]
    p: float


def paired_difference(
    first: NDArray[np.bool_], second: NDArray[np.bool_], *, resamples: int = 10_000, seed: int = 0
) -> PairedDifference:
    """Compare two agents that played the same episodes.

    Args:
        first: Success in each episode, shape (N,), N at least 1.
        second: The same of the other one.
        resamples: Bootstrap samples.
        seed: Seed of the bootstrap.
    """
    count = len(first)
    gained, lost = int((first & ~second).sum()), int((second & ~first).sum())
    # Episodes differ in three ways only: drawing their counts is drawing episodes.
    shares = np.array([gained, lost, count - gained - lost]) / count
    drawn = np.random.default_rng(seed).multinomial(count, shares, size=resamples)
    low, high = np.quantile((drawn[:, 0] - drawn[:, 1]) / count, [0.025, 0.975])
    return PairedDifference(
        (gained - lost) / count, (float(low), float(high)), mcnemar_p(lost, gained)
    )
