"""The probability of each sensor state vector **s**, and the sensor statuses that follow."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats

States = NDArray[np.bool_]
"""Sensor state vectors, shape (..., n + 1)."""
PRIOR_ATTACKED = 0.1
"""Probability of an attack on a sensor, before anything is seen."""
PRIOR_BEYOND = 0.1
"""How much rarer larger sets of attacked sensors are than if sensors were attacked independently:
sets that are too large for the thesis' algorithms."""


class SensorStatus(StrEnum):
    """What a validator reports of one sensor."""

    SOUND = "sound"
    ATTACKED = "attacked"
    CANNOT_TELL = "cannot tell"


@dataclass(frozen=True, eq=False)
class StatePosterior:
    """P(**s** | evidence) of N frames.

    Args:
        probabilities: A probability for each of the `state_vectors`, shape (N, 2^(n+1)).
    """

    probabilities: Floats

    @property
    def states(self) -> States:
        """Shape (2^(n+1), n + 1)."""
        return state_vectors(self.probabilities.shape[1].bit_length() - 1)

    @property
    def sensors(self) -> Floats:
        """P(s_i = 1 | evidence) of each sensor, shape (N, n + 1)."""
        return self.probabilities @ self.states

    @property
    def given_attack(self) -> Floats:
        """P(s_i = 1 | evidence, some sensor is attacked) of each sensor, shape (N, n + 1)."""
        attack = self.probabilities[:, 1:].sum(axis=1, keepdims=True)
        return np.asarray(self.sensors / np.maximum(attack, np.finfo(float).tiny))


@dataclass(frozen=True, eq=False)
class Decoding:
    """What follows from the evidence of N frames: the alarm, and the status of each sensor.

    Args:
        posterior: The probabilities of the sensor state vectors.
        alarms: Whether an attack is reported, at the designated false alarm rate, shape (N,).
        familiar: Whether some **s** explains the evidence as well as it does frames like those of
            the fit, shape (N,); else the probabilities mean little.
    """

    posterior: StatePosterior
    alarms: NDArray[np.bool_]
    familiar: NDArray[np.bool_]

    @property
    def states(self) -> States:
        """The most probable **s**: without alarm the clean one, with it the best of the others.

        Shape (N, n + 1).
        """
        best = 1 + self.posterior.probabilities[:, 1:].argmax(axis=1)
        return self.posterior.states[np.where(self.alarms, best, 0)]

    def statuses(self, certainty: float | None = 0.95) -> list[list[SensorStatus]]:
        """The status of each sensor of each frame.

        Without an alarm no sensor is attacked; with an alarm one or more are not sound.  A sensor
        is attacked where P(attacked) is `certainty` or more.  It is sound where P(attacked) is
        1 - `certainty` or less, with an alarm even given that some sensor is attacked, unless
        `states` names it.  Between the two, and in every frame that is not familiar, its status is
        open.

        Args:
            certainty: None: familiar frames are decided, by `states`.

        Raises:
            ConfigurationError: A certainty that is not above a half and up to 1.
        """
        if certainty is not None and not 0.5 < certainty <= 1:
            raise ConfigurationError(f"a certainty is above 0.5 and up to 1, got {certainty}")
        alarm, attacked = self.alarms[:, None], self.states
        sound = ~attacked
        if certainty is not None:
            suspicion = np.where(alarm, self.posterior.given_attack, self.posterior.sensors)
            sound &= suspicion <= 1.0 - certainty
            attacked = alarm & (self.posterior.sensors >= certainty)
        chosen = np.full(sound.shape, SensorStatus.CANNOT_TELL, object)
        chosen[sound] = SensorStatus.SOUND
        chosen[attacked] = SensorStatus.ATTACKED
        chosen[~self.familiar] = SensorStatus.CANNOT_TELL
        return chosen.tolist()


def state_vectors(sensors: int) -> States:
    """All 2^(n+1) sensor state vectors; the first one is clean, and bit i of an index is s_i.

    Example:
        >>> state_vectors(2).astype(int).tolist()
        [[0, 0], [1, 0], [0, 1], [1, 1]]
    """
    return np.asarray(np.arange(2**sensors)[:, None] >> np.arange(sensors) & 1 == 1)


def state_indices(states: States) -> NDArray[np.intp]:
    """Where state vectors stand in `state_vectors`, shape (...)."""
    return np.asarray(states @ (1 << np.arange(states.shape[-1])), np.intp)


def attack_prior(
    sensors: int, attacked: float = PRIOR_ATTACKED, beyond: float = PRIOR_BEYOND
) -> Floats:
    """P(**s**) where each sensor is attacked independently, and more than n - 2 rarer still.

    That there are never more, is what the thesis assumes; of three sensors one may be attacked.

    Args:
        sensors: The number of sensors, n + 1.
        attacked: The probability of an attack on each sensor.
        beyond: How much rarer larger sets are than if they were independent; 1: not at all.

    Returns:
        In the order of `state_vectors`, shape (2^(n+1),).

    Raises:
        ConfigurationError: A probability that is not between 0 and 1.
    """
    if not (0 < attacked < 1 and 0 < beyond <= 1):
        raise ConfigurationError(
            f"the probability of an attack is in (0, 1), got {attacked}; that there are more than "
            f"n - 2 is so many times rarer, above 0 and up to 1, got {beyond}"
        )
    count = state_vectors(sensors).sum(axis=1)
    independent = attacked**count * (1.0 - attacked) ** (sensors - count)
    prior = np.where(count > max(sensors - 3, 1), beyond, 1.0) * independent
    return np.asarray(prior / prior.sum())


def brier_score(posterior: StatePosterior, states: States, weights: Floats | None = None) -> float:
    """Mean squared distance between each sensor's probability and what it was (Brier 1950).

    Args:
        posterior: The probabilities of N frames.
        states: The true states, shape (N, n + 1).
        weights: How much each frame counts, shape (N,); None: as much as any other.

    Returns:
        0 for certainty that is right, 0.25 for one half everywhere, 1 for certainty that is wrong.
    """
    distances = ((posterior.sensors - states) ** 2).mean(axis=1)
    return float(np.average(distances, weights=weights))


def reliability(
    posterior: StatePosterior,
    states: States,
    weights: Floats | None = None,
    groups: ArrayLike | None = None,
    bins: int = 10,
) -> Floats:
    """How often sensors were attacked, by the predicted probability: a reliability diagram.

    Args:
        posterior: The probabilities of N frames.
        states: The true states, shape (N, n + 1).
        weights: How much each frame counts, shape (N,); None: as much as any other.
        groups: Frames of one group are alike, such as those of a drive, shape (N,); None: none
            are.
        bins: The number of bins of equal width from 0 to 1.

    Returns:
        For each bin the mean probability, the share that was attacked, the weight of its sensors,
        and as how many independent groups they count (Kish 1965), shape (bins, 4); NaN in an empty
        bin.
    """
    predicted, observed = posterior.sensors, np.asarray(states, float)
    weight = np.broadcast_to(np.ones(len(observed)) if weights is None else weights, len(observed))
    alike = (
        np.arange(len(observed)) if groups is None else np.unique(groups, return_inverse=True)[1]
    )
    which = np.minimum((predicted * bins).astype(int), bins - 1)
    table = np.zeros((bins, alike.max(initial=0) + 1))
    of_each = np.broadcast_to(weight[:, None], predicted.shape)
    np.add.at(table, (which, alike[:, None]), of_each)
    total = table.sum(axis=1)
    with np.errstate(invalid="ignore"):
        mean, share = (
            np.bincount(which.ravel(), (of_each * value).ravel(), bins) / total
            for value in (predicted, observed)
        )
        independent = total**2 / (table**2).sum(axis=1)
    return np.stack([mean, share, total, independent], axis=1)
