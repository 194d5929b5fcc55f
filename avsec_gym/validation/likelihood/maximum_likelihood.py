"""`LikelihoodModel`: the sensor state vector **s** from the evidence of all triples at once.

Algorithm 2 cuts every error off at a threshold, which must stand above the hardest clean scene.
But one scene is hard for all triples alike, while an attack moves only those that use an attacked
sensor.  So the evidence is modelled as a whole, on a scale u on which that of clean frames is
normally distributed, element by element (`NormalScores`):

    ln p(u | s) = w_1 ln f_1(u_1 | s) + ... + w_M ln f_M(u_M | s) + w_0 ln c(u | s) + offset.

An element's density f depends on which sensors of its own scope are attacked, so that attacks on
others leave it as it is, and an element that cannot see an attack has no weight.  The factor c
models what elements have in common, as a Gaussian copula: their correlation, once each is made
normal by its own f, depends on whether each of them is touched by the attack.  Were all this true,
the weights would be 1; a weighted composite likelihood (Varin, Reid and Firth, 2011) does not trust
it, and learns from held-out frames how much each term is worth, and an offset for each attacked
sensor, so that the probabilities are calibrated.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy import special

from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats
from avsec_gym.metrics.tolerance import rate_bound
from avsec_gym.validation.evidence.evidence import evidence_scopes
from avsec_gym.validation.fitted_on import FittedOn, broken, read_fitted, write_fitted
from avsec_gym.validation.likelihood.normal_scores import NormalScores
from avsec_gym.validation.likelihood.score_densities import (
    PATTERNS,
    SCORES,
    as_normal,
    element_patterns,
    interpolated,
    nearest_correlation,
)
from avsec_gym.validation.state_posterior import (
    Decoding,
    StatePosterior,
    attack_prior,
    state_vectors,
)

_KIND = "likelihoods"
_STRANGEST = 0.2
"""The part of the designated false alarm rate that is spent on frames like none of the fit."""
_MOST_DEPENDENCE = 60.0
"""The bound of ln c; what is far from all that was seen turns nothing over."""
_AT_ONCE = 4096
"""Frames, so that memory stays small."""
_BETWEEN = {
    "log_density": (-500.0, 50.0),
    "correlation": (-1.0 - 1e-9, 1.0 + 1e-9),
    "lowest": (-100.0, 100.0),
    "highest": (-100.0, 100.0),
    "weights": (0.0, 1e6),
    "offset": (-1e6, 1e6),
    "clean_scores": (-1e9, 1e9),
    "strangest": (-1e9, 1e9),
}
"""The smallest and the largest number that each parameter can hold; of log densities those whose
exponentials have a sum."""


@dataclass(frozen=True, eq=False)
class LikelihoodModel:
    """p(evidence | **s**); `fit_likelihood` makes it.

    M is the number of the evidence's elements; patterns count the attacked among an element's two
    or three sensors as bits, the first one lowest.

    Args:
        on: The sensors, the depth and the data.
        log_density: ln f of each element under each pattern, the clean one first, at `SCORES`
            scores from `LEAST_SCORE` on, shape (M, 8, SCORES); of pairs half of the patterns.
        correlation: Correlation of two elements, by whether the first and the second are touched,
            shape (2, 2, M, M).
        lowest: The lowest of the scores u seen, shape (M,); evidence below counts as this.
        highest: The same above.
        weights: Weights of the elements, and of c the last, 0 or more, shape (M + 1,).
        offset: The number that is added for each attacked sensor.
        scale: The scale of u, see `NormalScores`; None: log-odds.
        clean_scores: `alarm_scores` of clean frames that the fit held out, shape (any,).
        strangest: The largest, in the same frames, of their `strangeness`, clean and in all states
            that the fit held out, shape (any,).

    Raises:
        ConfigurationError: The arrays do not fit the system, or are no such parameters.
    """

    on: FittedOn
    log_density: Floats
    correlation: Floats
    lowest: Floats
    highest: Floats
    weights: Floats
    offset: float = 0.0
    scale: NormalScores | None = None
    clean_scores: Floats = field(default_factory=lambda: np.zeros(0))
    strangest: Floats = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        m = len(evidence_scopes(self.on.system))
        shapes = {
            "log_density": (m, PATTERNS, SCORES),
            "correlation": (2, 2, m, m),
            "lowest": (m,),
            "highest": (m,),
            "weights": (m + 1,),
            "offset": (),
            "clean_scores": (np.size(self.clean_scores),),
            "strangest": (np.size(self.clean_scores),),
        }
        for name, shape in shapes.items():
            array = np.array(getattr(self, name), float)
            if array.shape != shape:
                raise ConfigurationError(f"{name} is of shape {shape}, got shape {array.shape}")
            object.__setattr__(self, name, array if shape else float(array))
        for name, (low, high) in _BETWEEN.items():
            values = np.asarray(getattr(self, name), float)
            if not ((values >= low) & (values <= high)).all():  # Also true for NaN.
                raise ConfigurationError(f"{name} is from {low:.6g} to {high:.6g}")
        if (self.lowest > self.highest).any():
            raise ConfigurationError("the lowest of the scores lie below the highest")
        if self.scale is not None and len(self.scale.tails) != m:
            raise ConfigurationError(f"the scale is of {m} elements")

    @property
    def sensors(self) -> int:
        """How many: n + 1."""
        return len(self.on.system)

    def posterior(self, evidence: Floats, prior: Floats | None = None) -> StatePosterior:
        """P(**s** | evidence).

        Args:
            evidence: The evidence of N frames, shape (N, M); see `gather_evidence`.
            prior: P(**s**), shape (2^(n+1),); None: `attack_prior`, which the weights are learned
                for.

        Raises:
            ConfigurationError: Evidence or prior of another shape, or a prior that is none.
        """
        return self._posterior(self.log_likelihoods(evidence), prior)

    def log_likelihoods(self, evidence: Floats) -> Floats:
        """Ln p(evidence | **s**) but for a constant.

        Args:
            evidence: The shares, shape (N, M).

        Returns:
            In the order of `state_vectors`, shape (N, 2^(n+1)).
        """
        return self._judged(evidence)[0]

    def alarm_scores(self, evidence: Floats) -> Floats:
        """Log-odds that some sensor is attacked, under `attack_prior`, shape (N,)."""
        return self._alarm_scores(self.log_likelihoods(evidence))

    def strangeness(self, evidence: Floats) -> Floats:
        """How improbable the evidence is by the best **s**, shape (N,).

        -ln f, the mean of all elements.
        """
        return self._judged(evidence)[1]

    def terms(self, evidence: Floats) -> Floats:
        """The terms that are weighed: ln f of all elements, and ln c, shape (N, 2^(n+1), M + 1)."""
        if np.ndim(evidence) != 2 or np.shape(evidence)[1] != len(self.log_density):
            raise ConfigurationError(
                f"evidence has {len(self.log_density)} elements a frame, got shape "
                f"{np.shape(evidence)}"
            )
        # The shares as scores u, then ln f and normal scores z of each element under each pattern.
        scale = self.scale or NormalScores.plain(len(self.log_density))
        u = np.clip(scale(evidence), self.lowest, self.highest)
        of_patterns = np.stack([interpolated(u, self.log_density), interpolated(u, self._normal)])
        result = np.empty((len(u), len(self._patterns), len(self.weights)))
        element = np.arange(len(self.log_density))
        for state, patterns in enumerate(self._patterns):
            density, z = of_patterns[:, :, element, patterns]
            result[:, state, :-1] = density
            # ln c of a Gaussian copula: -1/2 (z C^-1 z - z z) - 1/2 ln det C.
            whitened = z @ self._whitenings[state].T
            excess = 0.5 * ((z**2).sum(axis=1) - (whitened**2).sum(axis=1))
            result[:, state, -1] = excess - self._log_widths[state]
        np.clip(result[..., -1], -_MOST_DEPENDENCE, _MOST_DEPENDENCE, out=result[..., -1])
        return result

    def decode(self, evidence: Floats, rate: float = 0.01, prior: Floats | None = None) -> Decoding:
        """The attacked sensors of N frames.

        Args:
            evidence: The shares, shape (N, M).
            rate: The designated false alarm rate r: the share of the held-out clean frames that are
                beyond a threshold, that of the `alarm_scores` or that of their `strangeness`.  The
                latter has a fifth of r; beyond it a frame is not familiar.  With fewer than 5 / r
                frames it is the largest that was held out.
            prior: The prior of the probabilities, see `posterior`; alarms do not depend on it.

        Raises:
            ConfigurationError: As `posterior`; a rate that is none; no clean frames were held out.
        """
        likelihoods, strangeness = self._judged(evidence)
        score, strangest = self._alarm_thresholds(rate)
        familiar = strangeness <= strangest
        alarms = ~familiar | (self._alarm_scores(likelihoods) > score)
        return Decoding(self._posterior(likelihoods, prior), alarms, familiar)

    def vouched_rate(self, rate: float) -> float:
        """The false alarm rate that the thresholds of `decode` keep, with 95 % confidence.

        As of `rate_bound`, of the held-out clean frames that they alarm at, if these frames are
        independent.

        Args:
            rate: The designated false alarm rate, as of `decode`.

        Raises:
            ConfigurationError: As of `decode`.
        """
        score, strangest = self._alarm_thresholds(rate)
        alarms = (self.strangest > strangest) | (self.clean_scores > score)
        return rate_bound(len(alarms), int(alarms.sum()))

    def write(self, path: str | Path, *, overwrite: bool = False) -> None:
        """Write all parameters as JSON, whole or not at all.

        Raises:
            DataError: The file exists and `overwrite` is false, or it cannot be written.
        """
        values = {name: np.asarray(getattr(self, name)).tolist() for name in _parameters()}
        scale = self.scale or NormalScores.plain(len(self.log_density))
        values["scale"] = {
            parameter.name: getattr(scale, parameter.name).tolist() for parameter in fields(scale)
        }
        write_fitted(path, _KIND, self.on, values, overwrite=overwrite)

    def _judged(self, evidence: Floats) -> tuple[Floats, Floats]:
        """Likelihoods and strangeness."""
        attacked = state_vectors(self.sensors).sum(axis=1)
        likelihoods, strangeness = [], []
        for some in np.array_split(evidence, max(1, -(-len(evidence) // _AT_ONCE))):
            terms = self.terms(some)
            likelihoods.append(terms @ self.weights + self.offset * attacked)
            strangeness.append(-terms[..., :-1].mean(axis=2).max(axis=1))
        return np.concatenate(likelihoods), np.concatenate(strangeness)

    def _posterior(self, likelihoods: Floats, prior: Floats | None) -> StatePosterior:
        return StatePosterior(special.softmax(likelihoods + self._log_prior(prior), axis=1))

    def _alarm_scores(self, likelihoods: Floats) -> Floats:
        scores = likelihoods + self._log_prior(None)
        return np.asarray(special.logsumexp(scores[:, 1:], axis=1) - scores[:, 0])

    def _alarm_thresholds(self, rate: float) -> tuple[float, float]:
        """Of scores and of strangeness, both together at the rate."""
        if not 0 <= rate <= 1 or not (count := len(self.clean_scores)):
            raise ConfigurationError(
                f"an alarm needs clean frames, of which there are {len(self.clean_scores)}, and a "
                f"rate from 0 to 1, got {rate}"
            )
        # A product such as 0.29 * 100 comes out just below the whole number that is meant.
        beyond, strange = int(rate * count + 1e-9), int(_STRANGEST * rate * count + 1e-9)
        strangest = np.sort(self.strangest)[-1 - strange]
        # Strange frames raise the alarm anyway: their score takes no part in the other threshold.
        scores = np.where(self.strangest > strangest, np.inf, self.clean_scores)
        return float(np.sort(np.r_[-np.inf, scores])[-1 - beyond]), float(strangest)

    def _log_prior(self, prior: Floats | None) -> Floats:
        prior = attack_prior(self.sensors) if prior is None else np.asarray(prior, float)
        if prior.shape != (2**self.sensors,) or not (prior >= 0).all() or prior.sum() <= 0:
            raise ConfigurationError(
                f"a prior has a probability for each of {2**self.sensors} state vectors"
            )
        with np.errstate(divide="ignore"):
            return np.asarray(np.log(prior / prior.sum()))

    @cached_property
    def _patterns(self) -> NDArray[np.intp]:
        """Of each element under each **s**, shape (2^(n+1), M)."""
        states = state_vectors(self.sensors)
        return element_patterns(states, evidence_scopes(self.on.system))

    @cached_property
    def _normal(self) -> Floats:
        """`as_normal` of each density, shape (M, 8, SCORES)."""
        return as_normal(self.log_density)

    @cached_property
    def _factors(self) -> Floats:
        """Cholesky factors of the correlations, shape (2^(n+1), M, M)."""
        element = np.arange(len(self.log_density))
        factors = []
        for touched in np.minimum(self._patterns, 1):
            pairs = self.correlation[touched[:, None], touched, element[:, None], element]
            factors.append(np.linalg.cholesky(nearest_correlation(pairs)))
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


def _parameters() -> list[str]:
    return [
        parameter.name
        for parameter in fields(LikelihoodModel)
        if parameter.name not in ("on", "scale")
    ]
