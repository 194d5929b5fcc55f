"""Quantiles of Student's t as a table: of a standard normal number, that with the same share below.

``stdtrit(freedom, ndtr(z))`` takes microseconds a number; drives need a dozen at each instant.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.special import ndtr, stdtrit

from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel

FARTHEST = 8.0
"""Normal numbers farther from 0 than this are taken for it: one in 10^15 is."""
_A_UNIT = 64


@lru_cache(maxsize=64)
def quantile_table(freedoms: Sequence[float]) -> Floats:
    """Splines of the inverse hyperbolic sine of t over normal numbers: tails become smooth lines.

    Args:
        freedoms: The degrees of freedom of K distributions, a tuple.

    Returns:
        Coefficients from the third power down, of K splines, shape (K, pieces, 4).
    """
    # The lower half alone: shares near 1 are known less well than those near 0.
    half = np.linspace(-FARTHEST, 0.0, int(FARTHEST * _A_UNIT) + 1)
    places = np.concatenate([half, -half[-2::-1]])
    splines = []
    for freedom in freedoms:
        below = np.arcsinh(stdtrit(freedom, ndtr(half)))
        below[-1] = 0.0
        splines.append(CubicSpline(places, np.concatenate([below, -below[-2::-1]])).c.T)
    return np.ascontiguousarray(splines)


@kernel(nogil=True)
def t_quantile(table: Floats, which: int, normal: float) -> float:
    """The number of a t distribution with as much below it as a standard normal one.

    Args:
        table: The table that `quantile_table` makes.
        which: Row of the distribution.
        normal: The normal number.
    """
    place = (min(max(normal, -FARTHEST), FARTHEST) + FARTHEST) * _A_UNIT
    piece = min(int(place), table.shape[1] - 1)
    beyond = (place - piece) / _A_UNIT
    value = 0.0
    for power in range(4):
        value = value * beyond + table[which, piece, power]
    return np.sinh(value)
