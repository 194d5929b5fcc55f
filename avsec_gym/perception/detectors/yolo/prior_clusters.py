"""Sizes of boxes that stand for all others: k-means by overlap (Redmon and Farhadi, 2017).

The priors of the preset `small` were made by it; docs/detectors.md shows how to make others.
"""

from __future__ import annotations

import numpy as np

from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats

_STARTS, _MOST_ROUNDS = 10, 300


def prior_clusters(sizes: Floats, count: int, seed: int = 0) -> Floats:
    """The priors of a data set.

    Args:
        sizes: Width and height of boxes in pixels of a network's input, shape (N, 2).
        count: The number of priors, not more than there are different sizes.
        seed: The seed of the boxes to begin with; the best of ten beginnings is taken.

    Returns:
        Width and height, smallest area first, shape (count, 2).

    Raises:
        ConfigurationError: Fewer different sizes than priors.
    """
    different = np.unique(sizes, axis=0)
    if not 0 < count <= len(different):
        raise ConfigurationError(f"{len(different)} different sizes make no {count} priors")
    random = np.random.default_rng(seed)
    starts = [random.choice(different, count, replace=False) for _ in range(_STARTS)]
    found = [_moved_to_middles(sizes, start) for start in starts]
    best = max(found, key=lambda priors: float(shape_overlaps(sizes, priors).max(1).mean()))
    return best[np.argsort(best.prod(1))]


def shape_overlaps(sizes: Floats, others: Floats) -> Floats:
    """Intersection over union of boxes (N, 2) and (M, 2) about one centre, shape (N, M)."""
    common = np.minimum(sizes[:, None], others[None]).prod(-1)
    return common / (sizes.prod(-1)[:, None] + others.prod(-1)[None] - common)


def _moved_to_middles(sizes: Floats, priors: Floats) -> Floats:
    for _ in range(_MOST_ROUNDS):
        owner = shape_overlaps(sizes, priors).argmax(1)
        moved = np.array(
            [
                np.median(sizes[owner == k], axis=0) if (owner == k).any() else priors[k]
                for k in range(len(priors))
            ]
        )
        if np.array_equal(moved, priors):
            break
        priors = moved
    return priors
