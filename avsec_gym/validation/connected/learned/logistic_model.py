"""Logistic regression with a ridge penalty, on features of the same scale."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.argument_checks import number
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.geometry import Floats

_MOST_STEPS = 100
_LARGEST = 1e9


@dataclass(frozen=True)
class LogisticModel:
    """Log odds of an attack: ``weights . (x - centre) / scale + offset``.

    Args:
        centre: The mean of each feature, F numbers.
        scale: The standard deviation of each feature, F positive numbers.
        weights: The weight of each standardised feature, F numbers.
        offset: Log odds of a mean region.

    Raises:
        ConfigurationError: Other numbers of features, a scale that is not positive, or a number
            that is not finite.
    """

    centre: tuple[float, ...]
    scale: tuple[float, ...]
    weights: tuple[float, ...]
    offset: float

    def __post_init__(self) -> None:
        if not len(self.centre) == len(self.scale) == len(self.weights) > 0:
            raise ConfigurationError("a logistic model has a centre, scale and weight a feature")
        for value in (*self.centre, *self.weights, self.offset):
            number("a number of a logistic model", value, -_LARGEST, _LARGEST)
        for value in self.scale:
            number("a scale of a logistic model", value, 1 / _LARGEST, _LARGEST)

    def log_odds(self, features: Floats) -> Floats:
        """Natural log odds of an attack, shape (N,).

        Args:
            features: Features of N regions, shape (N, F).
        """
        standard = (features - np.array(self.centre)) / np.array(self.scale)
        return np.asarray(standard @ np.array(self.weights) + self.offset)


def fit_logistic(
    features: Floats, attacked: NDArray[np.bool_], penalty: float = 1.0
) -> LogisticModel:
    """The model with the least logistic loss, by Newton's method.

    What is minimised is ``sum log(1 + exp(-y z)) + penalty / 2 |weights|^2`` over standardised
    features, with ``y`` of -1 or 1 and the log odds ``z``; the offset is free.  It is convex.

    Args:
        features: Features of N regions, shape (N, F).
        attacked: Whether each was attacked, shape (N,).
        penalty: How much large weights cost, above 0.

    Raises:
        DataError: Features that are not finite, or regions of one kind only.
        ConfigurationError: A penalty that is not positive.
    """
    penalty = number("penalty", penalty, 1e-9, _LARGEST)
    if not np.isfinite(features).all():
        raise DataError("Features are finite numbers.")
    if attacked.all() or not attacked.any():
        raise DataError("A model is fitted on attacked and attack-free regions.")
    centre, scale = features.mean(axis=0), features.std(axis=0)
    # What never varies weighs nothing, whatever its scale.
    scale = np.where(scale > 1e-9, scale, 1.0)
    inputs = np.c_[(features - centre) / scale, np.ones(len(features))]
    ridge = np.r_[np.full(features.shape[1], penalty), 0.0]
    sign = np.where(attacked, 1.0, -1.0)

    def loss(solution: Floats) -> float:
        odds = inputs @ solution
        return float(np.logaddexp(0, -sign * odds).sum() + 0.5 * (ridge * solution**2).sum())

    solution = np.zeros(inputs.shape[1])
    for _ in range(_MOST_STEPS):
        chance = 0.5 * (1.0 + np.tanh(0.5 * (inputs @ solution)))
        slopes = inputs.T @ (chance - attacked) + ridge * solution
        curves = inputs.T @ (inputs * (chance * (1 - chance))[:, None]) + np.diag(ridge)
        # A whisper keeps the offset's curve above 0 where all chances are 0 or 1.
        step = np.linalg.solve(curves + 1e-9 * np.eye(len(curves)), slopes)
        # A step that overshoots is halved until the loss falls.
        before, share = loss(solution), 1.0
        while share > 1e-6 and loss(solution - share * step) > before:
            share /= 2
        solution = solution - share * step
        if np.abs(share * step).max() < 1e-9:
            break
    *weights, offset = solution.tolist()
    return LogisticModel(
        tuple(centre.tolist()), tuple(scale.tolist()), tuple(weights), float(offset)
    )
