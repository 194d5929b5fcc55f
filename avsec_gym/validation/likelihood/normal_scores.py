"""Normal scores: how far out a share lies among those of clean frames, in standard deviations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import special

from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats

_SMALLEST_SHARE = 3e-4
"""Shares closer to 0 or 1 count as this close: three scan points in a window are no evidence."""
_BEYOND = 0.1
"""Share of clean frames, at most, that is taken for the tail."""
_SHORTEST_TAIL, _USUAL_TAIL = 0.05, 0.5
"""Log-odds: nothing falls off faster, however alike clean frames are; and what is taken for the
tail where there is none, since they are all equal."""
_QUANTILES = 200
_SMALLEST_CHANCE = 1e-100
_LARGEST = 100.0
"""Log-odds: those of the smallest share are a twelfth of it."""


@dataclass(frozen=True, eq=False)
class NormalScores:
    """A scale for each of M shares, on which clean frames are normally distributed.

    Up to the tail it is their ranks that count.  The tail falls off exponentially with the
    log-odds, so that what lies beyond all that was seen is the less probable, the farther out.

    Args:
        quantiles: Quantiles of clean frames' log-odds, ascending and evenly spread in probability,
            shape (Q, M); without any, scores are the log-odds.
        begins: Where the tail begins, log-odds, shape (M,).
        chances: Share of clean frames beyond where the tail begins, above 0, shape (M,).
        tails: The tails' mean excess, log-odds, shape (M,).

    Raises:
        ConfigurationError: The arrays are no such quantiles and tails.
    """

    quantiles: Floats
    begins: Floats
    chances: Floats
    tails: Floats

    def __post_init__(self) -> None:
        for name in ("begins", "chances", "tails"):
            object.__setattr__(self, name, np.array(getattr(self, name), float))
        m = len(self.tails) if self.tails.ndim else 0
        # Of no quantiles, a file does not hold the shape.
        quantiles = np.array(self.quantiles, float)
        object.__setattr__(self, "quantiles", quantiles if quantiles.size else np.zeros((0, m)))
        shapes = {self.begins.shape, self.chances.shape, self.tails.shape, (m,)}
        if len(shapes) > 1 or self.quantiles.shape[1:] != (m,):
            raise ConfigurationError(
                f"quantiles are of shape (Q, M), begins, chances and tails (M,), got "
                f"{self.quantiles.shape} and {shapes}"
            )
        values = (self.quantiles, self.begins, self.chances, self.tails)
        is_bounded = all((np.abs(array) <= _LARGEST).all() for array in values)  # NaN is not.
        is_positive = (self.tails > 0).all() and (self.chances > 0).all()
        is_share = (self.chances <= 1).all()
        ascends = not (np.diff(self.quantiles, axis=0) < 0).any()
        if not (is_bounded and is_positive and is_share and ascends):
            raise ConfigurationError(
                "quantiles ascend, chances are above 0 and up to 1, tails above 0, and no number is"
                f" beyond {_LARGEST:g}"
            )

    @classmethod
    def plain(cls, count: int) -> NormalScores:
        """Scores that are the log-odds of that many shares."""
        return cls(np.zeros((0, count)), *np.ones((3, count)))

    def __call__(self, shares: Floats) -> Floats:
        """The scores of N frames.

        Args:
            shares: The shares, from 0 to 1, shape (N, M).

        Returns:
            Finite, shape (N, M).
        """
        u = log_odds(shares)
        if not len(self.quantiles):
            return u
        levels = _levels(len(self.quantiles))
        scores = np.empty_like(u)
        for i, (odds, known) in enumerate(zip(u.T, self.quantiles.T, strict=True)):
            # Of equal quantiles the middle.
            last = np.interp(odds, known, levels)
            first = -np.interp(-odds, -known[::-1], -levels[::-1])
            beyond = np.maximum(odds - self.begins[i], 0.0) / self.tails[i]
            chance = np.where(
                odds > self.begins[i],
                np.maximum(self.chances[i] * np.exp(-beyond), _SMALLEST_CHANCE),
                np.maximum(1.0 - 0.5 * (first + last), self.chances[i]),
            )
            scores[:, i] = -special.ndtri(chance)
        return scores


def fit_normal_scores(clean: Floats) -> NormalScores:
    """The scale of clean frames.

    Args:
        clean: The shares of clean frames, shape (N, M).
    """
    u = log_odds(clean)
    quantiles = np.quantile(u, _levels(min(len(u), _QUANTILES)), axis=0, method="hazen")
    begins = np.quantile(u, 1.0 - _BEYOND, axis=0)
    # Strictly: where most are equal, few are beyond them.
    beyond = u > begins
    count = beyond.sum(axis=0)
    excess = np.where(beyond, u - begins, 0.0).sum(axis=0) / np.maximum(count, 1)
    tails = np.where(count > 0, np.maximum(excess, _SHORTEST_TAIL), _USUAL_TAIL)
    return NormalScores(quantiles, begins, np.maximum(count, 1) / (len(u) + 1), tails)


def log_odds(shares: Floats) -> Floats:
    """ln(p / (1 - p)), shape as given; finite for 0 and 1 too."""
    return np.asarray(
        special.logit(np.clip(np.asarray(shares, float), _SMALLEST_SHARE, 1.0 - _SMALLEST_SHARE))
    )


def _levels(count: int) -> Floats:
    return np.asarray((np.arange(count) + 0.5) / count)
