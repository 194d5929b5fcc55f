"""`LikelihoodModel`: the sensor state vector **s** from the evidence of all triples at once.

Algorithm 2 cuts every error off at a threshold, which must stand above the hardest clean scene.
But one scene is hard for all triples alike, while an attack moves only those that use an attacked
sensor.  So the evidence is modelled as a whole, on a scale u on which that of clean moments is
normally distributed, element by element (`NormalScores`):

    u ~ (mean(s), deviation(s) correlation(s) deviation(s)).

An element's mean and deviation depend on which sensors of its own scope are attacked, so that
attacks on others leave them as they are; the correlation of two elements on whether each of them is
touched by the attack: triples that share a map are not independent.  An element that cannot see an
attack has the same mean with and without it, and so no say.  The density of u is Student's: far
from all that was seen it does not turn certain.  An exponent tempers the likelihood, and an offset
for each attacked sensor levels it, until held-out moments find the probabilities honest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy import special

from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats
from avsec_gym.validation.evidence import Scope, evidence_scopes
from avsec_gym.validation.fitted_on import FittedOn, broken, read_fitted, write_fitted
from avsec_gym.validation.normal_scores import NormalScores
from avsec_gym.validation.state_posterior import (
    Decoding,
    StatePosterior,
    States,
    attack_prior,
    state_vectors,
)

PATTERNS = 8
"""In which the three sensors of a triple can be attacked or not."""
_KIND = "likelihoods"
_STRANGEST = 0.2
"""Of the designated false alarm rate that part which is spent on moments like none of the fit."""
_LEAST_EIGENVALUE = 0.02
"""Of a correlation matrix that was put together from pairs."""


@dataclass(frozen=True, eq=False)
class LikelihoodModel:
    """p(evidence | **s**); `fit_likelihood` makes it.

    M is the number of the evidence's elements; patterns count the attacked among an element's two
    or three sensors as bits, the first one lowest.

    Args:
        on: The sensors, the depth and the data.
        mean: Of u under each pattern, the clean one first, shape (M, 8).
        deviation: Standard deviation likewise, positive, shape (M, 8).
        correlation: Between two elements, by whether the first and the second are touched, shape
            (2, 2, M, M).
        lowest: Of the scores u seen, shape (M,); evidence below counts as this.
        highest: The same above.
        degrees_of_freedom: Of Student's distribution, above 2; its covariance is the given one.
        exponent: That tempers the likelihood.
        offset: Added to its logarithm for each attacked sensor.
        scale: Of u, see `NormalScores`; None: log-odds.
        clean_scores: `alarm_scores` of clean moments that the fit held out, shape (any,).
        farthest: Of the same moments the largest of their `distances`, clean and in all states that
            the fit held out, shape (any,).

    Raises:
        ConfigurationError: The arrays do not fit the system, or are no such parameters.
    """

    on: FittedOn
    mean: Floats
    deviation: Floats
    correlation: Floats
    lowest: Floats
    highest: Floats
    degrees_of_freedom: float
    exponent: float = 1.0
    offset: float = 0.0
    scale: NormalScores | None = None
    clean_scores: Floats = field(default_factory=lambda: np.zeros(0))
    farthest: Floats = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        m = len(evidence_scopes(self.on.system))
        shapes = {
            "mean": (m, PATTERNS),
            "deviation": (m, PATTERNS),
            "correlation": (2, 2, m, m),
            "lowest": (m,),
            "highest": (m,),
            "clean_scores": (np.size(self.clean_scores),),
            "farthest": (np.size(self.clean_scores),),
        }
        for name, shape in shapes.items():
            array = np.array(getattr(self, name), float)
            if array.shape != shape or not np.isfinite(array).all():
                raise ConfigurationError(
                    f"{name} is finite and of shape {shape}, got shape {array.shape}"
                )
            object.__setattr__(self, name, array)
        if self.scale is not None and len(self.scale.tails) != m:
            raise ConfigurationError(f"the scale is of {m} elements")
        if not (self.degrees_of_freedom > 2 and self.exponent > 0 and (self.deviation > 0).all()):
            raise ConfigurationError(
                "deviations and exponent are positive, and degrees of freedom more than 2"
            )

    @property
    def sensors(self) -> int:
        """How many: n + 1."""
        return len(self.on.system)

    def posterior(self, evidence: Floats, prior: Floats | None = None) -> StatePosterior:
        """P(**s** | evidence).

        Args:
            evidence: Of N moments, shape (N, M); see `gather_evidence`.
            prior: P(**s**), shape (2^(n+1),); None: `attack_prior`.

        Raises:
            ConfigurationError: Evidence or prior of another shape, or a prior that is none.
        """
        return self._posterior(self.log_likelihoods(evidence), prior)

    def log_likelihoods(self, evidence: Floats) -> Floats:
        """Tempered ln p(evidence | **s**) but for a constant.

        Args:
            evidence: Shares, shape (N, M).

        Returns:
            In the order of `state_vectors`, shape (N, 2^(n+1)).
        """
        return self._tempered(self._squared_distances(evidence))

    def alarm_scores(self, evidence: Floats) -> Floats:
        """Log-odds that some sensor is attacked, under `attack_prior`, shape (N,)."""
        return self._alarm_scores(self.log_likelihoods(evidence))

    def distances(self, evidence: Floats) -> Floats:
        """How far the evidence is from what the best **s** expects, shape (N,).

        In squared standard deviations for each element.
        """
        return self._distances(self._squared_distances(evidence))

    def decode(self, evidence: Floats, rate: float = 0.01, prior: Floats | None = None) -> Decoding:
        """The attacked sensors of N moments.

        Args:
            evidence: Shares, shape (N, M).
            rate: r, designated false alarm rate: the share of the held-out clean moments that are
                beyond a threshold, that of the `alarm_scores` or that of the `distances`.  The
                latter has a fifth of r; beyond it a moment is not familiar.  With fewer than 5 / r
                moments it is the largest that was held out.
            prior: Of the probabilities, see `posterior`; alarms do not depend on it.

        Raises:
            ConfigurationError: As `posterior`; a rate that is none; no clean moments were held out.
        """
        squared = self._squared_distances(evidence)
        likelihoods = self._tempered(squared)
        score, distance = self._alarm_thresholds(rate)
        familiar = self._distances(squared) <= distance
        alarms = ~familiar | (self._alarm_scores(likelihoods) > score)
        return Decoding(self._posterior(likelihoods, prior), alarms, familiar)

    def write(self, path: str | Path, *, overwrite: bool = False) -> None:
        """Write all parameters as JSON, whole or not at all.

        Raises:
            DataError: The file exists and `overwrite` is false, or it cannot be written.
        """
        values = {name: np.asarray(getattr(self, name)).tolist() for name in _parameters()}
        scale = self.scale or NormalScores.plain(len(self.mean))
        values["scale"] = {one.name: getattr(scale, one.name).tolist() for one in fields(scale)}
        write_fitted(path, _KIND, self.on, values, overwrite=overwrite)

    def _tempered(self, squared: Floats) -> Floats:
        nu, m = self.degrees_of_freedom, len(self.mean)
        tails = 0.5 * (nu + m) * np.log1p(squared / (nu - 2.0))
        attacked = state_vectors(self.sensors).sum(axis=1)
        return np.asarray(self.offset * attacked - self.exponent * (self._log_widths + tails))

    def _posterior(self, likelihoods: Floats, prior: Floats | None) -> StatePosterior:
        return StatePosterior(special.softmax(likelihoods + self._log_prior(prior), axis=1))

    def _alarm_scores(self, likelihoods: Floats) -> Floats:
        scores = likelihoods + self._log_prior(None)
        return np.asarray(special.logsumexp(scores[:, 1:], axis=1) - scores[:, 0])

    def _distances(self, squared: Floats) -> Floats:
        return np.asarray(squared.min(axis=1) / len(self.mean))

    def _alarm_thresholds(self, rate: float) -> tuple[float, float]:
        """Of scores and of distances, both together at the rate."""
        if not 0 <= rate <= 1 or not (count := len(self.clean_scores)):
            raise ConfigurationError(
                f"an alarm needs clean moments, of which there are {len(self.clean_scores)}, and a "
                f"rate from 0 to 1, got {rate}"
            )
        # A product such as 0.29 * 100 comes out just below the whole number that is meant.
        beyond, strange = int(rate * count + 1e-9), int(_STRANGEST * rate * count + 1e-9)
        distance = np.sort(self.farthest)[-1 - strange]
        # Who is strange raises the alarm anyway: nobody is beyond that score.
        scores = np.where(self.farthest > distance, np.inf, self.clean_scores)
        return float(np.sort(np.r_[-np.inf, scores])[-1 - beyond]), float(distance)

    def _log_prior(self, prior: Floats | None) -> Floats:
        prior = attack_prior(self.sensors) if prior is None else np.asarray(prior, float)
        if prior.shape != (2**self.sensors,) or not (prior >= 0).all() or prior.sum() <= 0:
            raise ConfigurationError(
                f"a prior has a probability for each of {2**self.sensors} state vectors"
            )
        with np.errstate(divide="ignore"):
            return np.asarray(np.log(prior / prior.sum()))

    def _squared_distances(self, evidence: Floats) -> Floats:
        """Mahalanobis distances from what each **s** expects, shape (N, 2^(n+1))."""
        if np.ndim(evidence) != 2 or np.shape(evidence)[1] != len(self.mean):
            raise ConfigurationError(
                f"evidence has {len(self.mean)} elements a moment, got shape {np.shape(evidence)}"
            )
        scale = self.scale or NormalScores.plain(len(self.mean))
        u = np.clip(scale(evidence), self.lowest, self.highest)
        result = np.empty((len(u), len(self._means)))
        for state, (mean, whitening) in enumerate(zip(self._means, self._whitenings, strict=True)):
            result[:, state] = (((u - mean) @ whitening.T) ** 2).sum(axis=1)
        return result

    @cached_property
    def _patterns(self) -> NDArray[np.intp]:
        """Of each element under each **s**, shape (2^(n+1), M)."""
        states = state_vectors(self.sensors)
        return element_patterns(states, evidence_scopes(self.on.system))

    @cached_property
    def _means(self) -> Floats:
        return np.asarray(np.take_along_axis(self.mean, self._patterns.T, axis=1).T)

    @cached_property
    def _factors(self) -> Floats:
        """Cholesky factors of the covariances, shape (2^(n+1), M, M)."""
        deviations = np.take_along_axis(self.deviation, self._patterns.T, axis=1).T
        element = np.arange(len(self.mean))
        factors = []
        for deviation, touched in zip(deviations, np.minimum(self._patterns, 1), strict=True):
            pairs = self.correlation[touched[:, None], touched, element[:, None], element]
            covariance = deviation[:, None] * _nearest_correlation(pairs) * deviation
            factors.append(np.linalg.cholesky(covariance))
        return np.array(factors)

    @cached_property
    def _whitenings(self) -> Floats:
        return np.asarray(np.linalg.inv(self._factors))

    @cached_property
    def _log_widths(self) -> Floats:
        """Half the log-determinants, shape (2^(n+1),)."""
        return np.asarray(np.log(np.diagonal(self._factors, axis1=1, axis2=2)).sum(axis=1))


def read_likelihood_model(path: str | Path) -> LikelihoodModel:
    """Read what `LikelihoodModel.write` wrote.

    Raises:
        DataError: Missing, cut off, or something else.
    """
    on, content = read_fitted(path, _KIND)
    try:
        scale = NormalScores(**content["scale"])
        return LikelihoodModel(on, scale=scale, **{name: content[name] for name in _parameters()})
    except (KeyError, TypeError, ValueError, ConfigurationError) as error:
        raise broken(path, error) from error


def element_patterns(states: States, scopes: Sequence[Scope]) -> NDArray[np.intp]:
    """Which of its own sensors are attacked, for each element of the evidence.

    Args:
        states: Shape (N, n + 1).
        scopes: Of the M elements.

    Returns:
        The attacked sensors of the scope as bits, the first one lowest, shape (N, M).
    """
    return np.stack([states[:, scope] @ (1 << np.arange(len(scope))) for scope in scopes], axis=1)


def _nearest_correlation(pairs: Floats) -> Floats:
    """A correlation matrix like what was put together from pairs, which may be none."""
    values, vectors = np.linalg.eigh(pairs)
    valid = (vectors * np.maximum(values, _LEAST_EIGENVALUE)) @ vectors.T
    scale = np.sqrt(np.diagonal(valid))
    return np.asarray(valid / np.outer(scale, scale))


def _parameters() -> list[str]:
    return [one.name for one in fields(LikelihoodModel) if one.name not in ("on", "scale")]
