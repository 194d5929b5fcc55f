"""Theta: the distance beyond which two surfaces are not of one thing (section 4.4.4)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from avsec_gym.errors import ConfigurationError


def distance_threshold(attack_free: ArrayLike, rate: float) -> float:
    """Theta at a designated false positive rate r.

    An order statistic: of N distances floor(r N) lie beyond it, fewer where some are equal.

    Args:
        attack_free: Distances of surfaces of which none was attacked, metres, any shape; NaN, of
            pairs that compared nothing, does not count.
        rate: The share r of the samples that lie beyond theta, from 0 to 1.

    Returns:
        Metres; -1 for a rate of 1, which lies below every distance.

    Raises:
        ConfigurationError: There is no distance, one is negative or infinite, or the rate cannot
            be.

    Example:
        >>> distance_threshold(np.arange(10), 0.2)
        7.0
    """
    samples = np.asarray(attack_free, float).ravel()
    samples = np.sort(samples[~np.isnan(samples)])
    if not len(samples) or not (samples >= 0).all() or not np.isfinite(samples).all():
        raise ConfigurationError("a threshold takes one distance or more, all of 0 m or more")
    if not 0 <= rate <= 1:
        raise ConfigurationError(f"the false positive rate is from 0 to 1, got {rate}")
    # A product such as 0.29 * 100 comes out just below the whole number that is meant.
    beyond = int(rate * len(samples) + 1e-9)
    return -1.0 if beyond >= len(samples) else float(samples[len(samples) - 1 - beyond])
