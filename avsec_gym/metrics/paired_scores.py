"""Two agents in the same episodes: how much more often one reaches its aim."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.metrics.cluster_bootstrap import LOW_AND_HIGH
from avsec_gym.metrics.intervals import mcnemar_p


@dataclass(frozen=True)
class PairedDifference:
    """Success of the first less that of the second.

    Args:
        difference: The difference of the rates.
        interval: 95 % percentile interval of a bootstrap that draws scenes, with all their
            episodes; None of a single scene.
        p: McNemar's exact test; None where a scene has several episodes, which depend on each
            other.
    """

    difference: float
    interval: tuple[float, float] | None
    p: float | None


def paired_difference(
    first: NDArray[np.bool_],
    second: NDArray[np.bool_],
    scenes: Sequence[str],
    *,
    resamples: int = 10_000,
    seed: int = 0,
) -> PairedDifference:
    """Compare two agents that played the same episodes.

    Args:
        first: Success in each episode, shape (N,), N at least 1.
        second: The same of the other one.
        scenes: The scene of each episode, N names: episodes of one are a cluster.
        resamples: Bootstrap samples.
        seed: Seed of the bootstrap.
    """
    gained, lost = first & ~second, second & ~first
    difference = float((gained.sum() - lost.sum()) / len(first))
    _, scene = np.unique(np.asarray(scenes), return_inverse=True)
    counts = np.stack([np.bincount(scene, gained), np.bincount(scene, lost), np.bincount(scene)], 1)
    if len(counts) < 2:
        return PairedDifference(difference, None, None)
    # Scenes of equal counts, of which there are few kinds, are drawn together.
    kinds, number = np.unique(counts, axis=0, return_counts=True)
    drawn = np.random.default_rng(seed).multinomial(
        len(counts), number / len(counts), size=resamples
    )
    won, missed, episodes = (drawn @ kinds).T
    low, high = np.quantile((won - missed) / episodes, LOW_AND_HIGH)
    alone = len(counts) == len(first)
    p = mcnemar_p(int(lost.sum()), int(gained.sum())) if alone else None
    return PairedDifference(difference, (float(low), float(high)), p)
