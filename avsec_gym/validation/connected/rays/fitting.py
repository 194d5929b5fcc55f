"""Rates and calibration of rays, fitted on instants that are never judged."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from avsec_gym.argument_checks import number
from avsec_gym.errors import DataError
from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.rays.rates import RayRates, decidable, log_likelihood_ratio

_LARGEST = 1e6
_MOST = (2.0, 3.0, 5.0, 8.0, 12.0, 20.0, 40.0)


@dataclass(frozen=True, eq=False)
class LabelledCounts:
    """Testimonies of which the truth is known.

    Args:
        present: Counts of claims of what is there and what the witness can see, shape (P, 3).
        absent: Counts of claims of ghosts, and of objects removed from the witness' scan, shape
            (A, 3).
    """

    present: NDArray[np.int64]
    absent: NDArray[np.int64]

    def decidable(self, least: int) -> LabelledCounts:
        """The regions with so many telling rays."""
        rates = RayRates(least=least)
        return LabelledCounts(
            self.present[decidable(self.present, rates)], self.absent[decidable(self.absent, rates)]
        )


def fit_rates(testimonies: LabelledCounts, least: int = 5) -> RayRates:
    """Rates of rays from testimonies of which the truth is known.

    Chances are means over testimonies, each of the same weight.  The number of effective rays is
    that of `_MOST` with the least logistic loss over both kinds, each kind of the same weight.

    Args:
        testimonies: Testimonies of attack-free and of attacked instants.
        least: Number of telling rays below which a testimony decides nothing.

    Raises:
        DataError: Fewer than 10 decidable testimonies of a kind.
    """
    chosen = testimonies.decidable(least)
    present, absent = chosen.present, chosen.absent
    if min(len(present), len(absent)) < 10:
        raise DataError(
            f"There are {len(present)} decidable testimonies of what is there and {len(absent)} of"
            " what is not; rates are fitted on 10 of each or more.",
            remedy="Take more instants.",
        )
    there, gone = _chances(present), _chances(absent)
    fitted = RayRates(
        support_present=float(there[0]),
        through_present=float(there[1]),
        missing_present=float(there[2]),
        support_absent=float(gone[0]),
        through_absent=float(gone[1]),
        missing_absent=float(gone[2]),
        least=least,
    )
    options = [replace(fitted, most=most) for most in _MOST]
    return min(options, key=lambda rates: logistic_loss(chosen, rates))


def logistic_loss(testimonies: LabelledCounts, rates: RayRates) -> float:
    """Mean logistic loss of the log-likelihood ratios, both kinds of the same weight."""
    present = log_likelihood_ratio(testimonies.present, rates)
    absent = log_likelihood_ratio(testimonies.absent, rates)
    return float(np.logaddexp(0, present).mean() + np.logaddexp(0, -absent).mean()) / 2


@dataclass(frozen=True)
class ScoreProbability:
    """The probability of a score: ``1 / (1 + exp(-(slope * score + offset)))``.

    Args:
        slope: How many nats of odds a unit of the score is worth.
        offset: Log odds at the score 0.

    Raises:
        ConfigurationError: A number that is not finite, or beyond a million.
    """

    slope: float = 1.0
    offset: float = 0.0

    def __post_init__(self) -> None:
        for name in ("slope", "offset"):
            number(name, getattr(self, name), -_LARGEST, _LARGEST)

    def probability(self, scores: ArrayLike) -> Floats:
        """Probabilities of an attack, of the scores' shape."""
        odds = self.slope * np.asarray(scores, np.float64) + self.offset
        return np.asarray(0.5 * (1.0 + np.tanh(0.5 * odds)))


_RAREST = 1e-6
"""Share of attacked regions below which, or above one minus which, odds are no longer numbers."""


def fit_calibration(
    scores: ArrayLike, attacked: ArrayLike, prior: float | None = None
) -> ScoreProbability:
    """Logistic regression of attacks on scores, with targets a little off 0 and 1 (Platt, 1999).

    Args:
        scores: Scores of regions, shape (N,).
        attacked: Whether each was attacked, shape (N,).
        prior: Share of attacked regions where probabilities will be used; that of the data if
            None.

    Raises:
        DataError: Only one kind of regions, or a score that is not finite.
        ConfigurationError: A prior of 0 or 1.
    """
    if prior is not None:
        prior = number("prior", prior, _RAREST, 1 - _RAREST)
    score, truth = np.asarray(scores, np.float64), np.asarray(attacked, bool)
    if not np.isfinite(score).all():
        raise DataError("Scores are finite: leave out regions in which nothing was decidable.")
    ones, zeros = int(truth.sum()), int((~truth).sum())
    if not ones or not zeros:
        raise DataError("A calibration is fitted on attacked and attack-free regions.")
    target = np.where(truth, (ones + 1) / (ones + 2), 1 / (zeros + 2))
    scale = max(float(score.std()), 1e-9)
    inputs = np.stack([(score - score.mean()) / scale, np.ones_like(score)], axis=1)
    solution = np.zeros(2)
    # Newton's method, with a whisper of regularisation for data that a threshold separates.
    for _ in range(50):
        chance = 0.5 * (1.0 + np.tanh(0.5 * (inputs @ solution)))
        slopes = inputs.T @ (chance - target) + 1e-3 * solution
        curves = inputs.T @ (inputs * (chance * (1 - chance))[:, None]) + 1e-3 * np.eye(2)
        step = np.linalg.solve(curves, slopes)
        solution -= np.clip(step, -2.0, 2.0)
        if np.abs(step).max() < 1e-9:
            break
    slope = float(solution[0]) / scale
    offset = float(solution[1]) - slope * float(score.mean())
    if prior is not None:
        offset += float(np.log(prior / (1 - prior)) - np.log(ones / zeros))
    return ScoreProbability(slope, offset)


def _chances(counts: NDArray[np.int64]) -> Floats:
    """Mean shares of supporting, passing and missing rays, never quite 0, shape (3,)."""
    share = (counts / counts.sum(axis=1, keepdims=True)).mean(axis=0) + 0.5 / len(counts)
    return np.asarray(share / share.sum())
