"""Holm's correction: of many comparisons at once, which are sure?

A p-value below 0.05 comes about by chance in one comparison of twenty: of 66 pairs of attacks that
all do the same, three would differ "surely".  Holm's method (1979) keeps the probability of even
one false finding below alpha, whatever the comparisons have to do with each other.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from avsec_gym.argument_checks import number
from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats

ALPHA = 0.05
"""The usual probability of one false finding or more among all comparisons."""


def holm_adjusted(p_values: ArrayLike) -> Floats:
    """Holm's adjusted p-values: one of at most alpha is a finding at the level alpha.

    Of n sorted p-values the k-th (from 0) counts n - k times, and none less than those before it:
    the closed testing principle over Bonferroni's tests of all subsets (Holm 1979, "A simple
    sequentially rejective multiple test procedure").

    Args:
        p_values: One for each comparison, from 0 to 1, any shape; NaN: there was nothing to test,
            and the comparison does not count among the others.

    Returns:
        The same shape, from 0 to 1; NaN where the p-value was.

    Raises:
        ConfigurationError: A p-value is below 0 or above 1.

    Example:
        >>> holm_adjusted([0.01, 0.04, 0.03]).round(3)
        array([0.03, 0.06, 0.06])
    """
    p = np.array(p_values, float)
    tested = ~np.isnan(p)
    known = p[tested]
    if not ((known >= 0) & (known <= 1)).all():
        raise ConfigurationError(f"p-values are from 0 to 1, got {known.min()} to {known.max()}")
    order = np.argsort(known, kind="stable")
    counted = known[order] * np.arange(len(known), 0, -1)
    adjusted = np.empty_like(known)
    adjusted[order] = np.minimum(np.maximum.accumulate(counted), 1.0)
    p[tested] = adjusted
    return p


def holm_findings(p_values: ArrayLike, alpha: float = ALPHA) -> NDArray[np.bool_]:
    """Which comparisons are sure, with a probability of at most alpha that any of them is false.

    Args:
        p_values: The p-values of the comparisons, as of `holm_adjusted`.
        alpha: The probability, above 0 and below 1.

    Returns:
        The same shape; false where there was nothing to test.

    Raises:
        ConfigurationError: A p-value or alpha cannot be.

    Example:
        >>> holm_findings([0.01, 0.04, 0.03])
        array([ True, False, False])
    """
    level = number("alpha", alpha, np.nextafter(0.0, 1.0), np.nextafter(1.0, 0.0))
    found: NDArray[np.bool_] = holm_adjusted(p_values) <= level
    return found
