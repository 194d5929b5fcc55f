"""What a threshold can vouch for that was set at an order statistic of a few clean samples.

Of n independent samples k lie above the threshold.  The share of all clean cases that lies above it
is then a random number of known distribution, Beta(k + 1, n - k), whatever the samples are
distributed like (Wilks 1941, "Determination of sample sizes for setting tolerance limits"): k / n
is no more than its middle, and of few samples it may be several times as large.  A one-sided
tolerance bound states the rate that is kept with a confidence of 95 %.  Samples that are alike,
such as frames of one drive, are fewer than they seem: n is then the number of drives, and k that of
drives with a sample above.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import bdtr, betaincinv

from avsec_gym.argument_checks import number, whole_number
from avsec_gym.errors import ConfigurationError

CONFIDENCE = 0.95
_MOST_SAMPLES = 10**9


def rate_bound(samples: int, above: int, confidence: float = CONFIDENCE) -> float:
    """The false positive rate that a threshold keeps with this confidence.

    Args:
        samples: n, the number of independent clean samples that the threshold was set at.
        above: k, how many of them lie above it.
        confidence: The probability, over draws of the samples, that the bound holds.

    Returns:
        The share of all clean cases that lies above at most, from 0 to 1: the quantile of
        Beta(k + 1, n - k); 1 where all samples lie above.

    Raises:
        ConfigurationError: The counts or the confidence cannot be.

    Example:
        >>> round(rate_bound(100, 1), 4)  # One of a hundred does not vouch for one percent.
        0.0466
    """
    n, k = _counts(samples, above)
    return 1.0 if k == n else float(betaincinv(k + 1, n - k, _confidence(confidence)))


def largest_above(samples: int, rate: float, confidence: float = CONFIDENCE) -> int | None:
    """How many samples may lie above a threshold that is to keep a rate with this confidence.

    Args:
        samples: n, the number of independent clean samples.
        rate: r, the false positive rate to keep, above 0 and below 1.
        confidence: The probability that the bound holds, as of `rate_bound`.

    Returns:
        The largest k with ``rate_bound(n, k) <= r``; None where no threshold among so few samples
        keeps the rate, not even the largest of them: see `fewest_samples`.

    Raises:
        ConfigurationError: An argument cannot be.

    Example:
        >>> largest_above(298, 0.01), largest_above(299, 0.01), largest_above(473, 0.01)
        (None, 0, 1)
    """
    n, _ = _counts(samples, 0)
    r, doubt = _rate(rate), 1 - _confidence(confidence)
    # The bound holds where so few as k of n fall above a share r with a probability of 1 - c.
    if bdtr(0, n, r) > doubt:
        return None
    low, high = 0, n  # Invariant: low keeps the rate, high does not.
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if bdtr(middle, n, r) <= doubt else (low, middle)
    return low


def fewest_samples(rate: float, above: int = 0, confidence: float = CONFIDENCE) -> int:
    """How many samples a threshold needs of which k lie above it, to keep a rate.

    Args:
        rate: r, the false positive rate to keep, above 0 and below 1.
        above: k, how many samples are to lie above; 0: the threshold is the largest sample.
        confidence: The probability that the bound holds, as of `rate_bound`.

    Returns:
        The smallest n with ``rate_bound(n, k) <= r``.

    Raises:
        ConfigurationError: An argument cannot be, or more than a billion samples are needed.

    Example:
        >>> fewest_samples(0.01), fewest_samples(0.01, above=1), fewest_samples(0.05)
        (299, 473, 59)
    """
    k = whole_number("above", above, 0, _MOST_SAMPLES - 1)
    r, doubt = _rate(rate), 1 - _confidence(confidence)
    low, high = k, k + 1  # Invariant: low samples are too few; of n = k all lie above.
    while bdtr(k, high, r) > doubt:
        low, high = high, 2 * high
        if low > _MOST_SAMPLES:
            raise ConfigurationError(f"a rate of {r:g} takes more than a billion samples")
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if bdtr(k, middle, r) > doubt else (low, middle)
    return high


@dataclass(frozen=True)
class ToleranceThreshold:
    """A threshold of clean samples, and what it can vouch for.

    Args:
        value: The threshold; what lies above it is an alarm.
        clusters: n, how many clusters of clean samples it was set at.
        above: k, how many of them have a sample above it.
        vouched: The false positive rate that it keeps, see `rate_bound`.
        fewest: How many clusters it takes to vouch for the rate that was asked for.
    """

    value: float
    clusters: int
    above: int
    vouched: float
    fewest: int


def tolerance_threshold(
    values: ArrayLike, clusters: Sequence[str], rate: float, confidence: float = CONFIDENCE
) -> ToleranceThreshold:
    """The lowest threshold that keeps a false positive rate with this confidence.

    Of each cluster its largest value counts.  Among n clusters the threshold has k above it, as
    many as `largest_above` allows; with too few for any it is the largest value of all, and vouches
    for less than was asked for.

    Args:
        values: Clean values, shape (N,).
        clusters: Cluster that each value belongs to, N names.
        rate: r, the false positive rate to keep, above 0 and below 1.
        confidence: The probability that the bound holds, as of `rate_bound`.

    Raises:
        ConfigurationError: No values, or an argument cannot be.

    Example:
        >>> found = tolerance_threshold([0.1, 0.3, 0.2], ["a", "b", "b"], 0.01)
        >>> found.value, found.clusters, found.above, round(found.vouched, 6), found.fewest
        (0.3, 2, 0, 0.776393, 299)
    """
    names, cluster = np.unique(np.asarray(clusters, str), return_inverse=True)
    n = _counts(len(names), 0)[0]
    largest = np.full(n, -np.inf)
    np.maximum.at(largest, cluster, np.asarray(values, float))
    allowed = largest_above(n, rate, confidence) or 0
    value = float(np.sort(largest)[n - 1 - allowed])
    # Of equal values fewer lie above.
    above = int((largest > value).sum())
    vouched = rate_bound(n, above, confidence)
    return ToleranceThreshold(value, n, above, vouched, fewest_samples(rate, 0, confidence))


def _counts(samples: int, above: int) -> tuple[int, int]:
    n = whole_number("samples", samples, 1, _MOST_SAMPLES)
    return n, whole_number("above", above, 0, n)


def _rate(rate: float) -> float:
    return number("rate", rate, np.nextafter(0.0, 1.0), np.nextafter(1.0, 0.0))


def _confidence(confidence: float) -> float:
    return number("confidence", confidence, 0.5, np.nextafter(1.0, 0.0))
