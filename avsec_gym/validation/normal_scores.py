"""Normal scores: how far out a share lies among those of clean moments, in standard deviations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import special

from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats

_SMALLEST_SHARE = 1e-4
"""Shares closer to 0 or 1 count as this close: fifty pixels of a view say no more."""
_BEYOND = 0.1
"""Share of clean moments that is taken for the tail."""
_SHORTEST_TAIL = 0.05
"""Log-odds; nothing falls off faster, however alike clean moments are."""
_QUANTILES = 200
_SMALLEST_CHANCE = 1e-100


@dataclass(frozen=True, eq=False)
class NormalScores:
    """A scale for each of M shares, on which clean moments are normally distributed.

    Up to the tail it is their ranks that count.  The tail falls off exponentially with the
    log-odds, so that what lies beyond all that was seen is the less probable, the farther out.

    Args:
        quantiles: Of clean moments' log-odds, ascending and evenly spread in probability, shape
            (Q, M); without any, scores are the log-odds.
        tails: Mean excess over the point that `_BEYOND` of them are beyond, shape (M,).

    Raises:
        ConfigurationError: The arrays are no such quantiles and tails.
    """

    quantiles: Floats
    tails: Floats

    def __post_init__(self) -> None:
        quantiles, tails = np.array(self.quantiles, float), np.array(self.tails, float)
        if quantiles.ndim != 2 or tails.shape != quantiles.shape[1:]:
            raise ConfigurationError(
                f"quantiles are of shape (Q, M) and tails (M,), got {quantiles.shape} and "
                f"{tails.shape}"
            )
        is_sound = np.isfinite(quantiles).all() and (tails > 0).all() and np.isfinite(tails).all()
        if not is_sound or (np.diff(quantiles, axis=0) < 0).any():
            raise ConfigurationError("quantiles ascend, and tails are positive")
        object.__setattr__(self, "quantiles", quantiles)
        object.__setattr__(self, "tails", tails)

    def __call__(self, shares: Floats) -> Floats:
        """The scores of N moments.

        Args:
            shares: From 0 to 1, shape (N, M).

        Returns:
            Finite, shape (N, M).
        """
        u = log_odds(shares)
        if not len(self.quantiles):
            return u
        levels = _levels(len(self.quantiles))
        columns = zip(u.T, self.quantiles.T, self.tails, strict=True)
        return np.stack([_scores(one, known, levels, tail) for one, known, tail in columns], axis=1)


def fit_normal_scores(clean: Floats) -> NormalScores:
    """The scale of clean moments.

    Args:
        clean: Their shares, shape (N, M).
    """
    u = log_odds(clean)
    quantiles = np.quantile(u, _levels(min(len(u), _QUANTILES)), axis=0, method="hazen")
    begin = np.quantile(u, 1.0 - _BEYOND, axis=0)
    beyond = u >= begin
    excess = np.where(beyond, u - begin, 0.0).sum(axis=0) / np.maximum(beyond.sum(axis=0), 1)
    return NormalScores(quantiles, np.maximum(excess, _SHORTEST_TAIL))


def log_odds(shares: Floats) -> Floats:
    """ln(p / (1 - p)), shape as given; finite for 0 and 1 too."""
    return np.asarray(
        special.logit(np.clip(np.asarray(shares, float), _SMALLEST_SHARE, 1.0 - _SMALLEST_SHARE))
    )


def _levels(count: int) -> Floats:
    return np.asarray((np.arange(count) + 0.5) / count)


def _scores(u: Floats, quantiles: Floats, levels: Floats, tail: float) -> Floats:
    # Of equal quantiles the middle.
    last = np.interp(u, quantiles, levels)
    first = -np.interp(-u, -quantiles[::-1], -levels[::-1])
    begin = np.interp(1.0 - _BEYOND, levels, quantiles)
    chance = np.where(
        u > begin,
        np.maximum(_BEYOND * np.exp(-(u - begin) / tail), _SMALLEST_CHANCE),
        np.maximum(1.0 - 0.5 * (first + last), _BEYOND),
    )
    return np.asarray(-special.ndtri(chance))
