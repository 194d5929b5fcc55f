"""Uncertainty of shares: Wilson's interval and McNemar's test."""

from __future__ import annotations

import math

_Z95 = 1.959963984540054
"""Normal quantile of a two-sided 95 % interval."""


def wilson_interval(successes: float, cases: float, z: float = _Z95) -> tuple[float, float]:
    """Wilson's score interval of a share (Wilson 1927).

    Args:
        successes: Number of successes.
        cases: Number of cases; of cases that are alike, as many as they count for.
        z: Normal quantile; the default gives 95 %.

    Returns:
        Lower and upper bound; nan, nan without cases.

    Example:
        >>> [round(bound, 3) for bound in wilson_interval(9, 10)]
        [0.596, 0.982]
    """
    if cases == 0:
        return (math.nan, math.nan)
    share = successes / cases
    centre = share + z * z / (2 * cases)
    spread = z * math.sqrt(share * (1 - share) / cases + z * z / (4 * cases * cases))
    scale = 1 + z * z / cases
    low = 0.0 if successes == 0 else (centre - spread) / scale
    high = 1.0 if successes == cases else (centre + spread) / scale
    return (low, high)


def mcnemar_p(lost: int, gained: int) -> float:
    """Two-sided exact p-value that as many pairs change one way as the other (McNemar 1947).

    Example:
        >>> round(mcnemar_p(8, 1), 4)
        0.0391
    """
    changed = lost + gained
    tail, ways = 0, 1
    for k in range(min(lost, gained) + 1):
        tail += ways
        ways = ways * (changed - k) // (k + 1)
    return min(1.0, 2 * tail / 2**changed)
