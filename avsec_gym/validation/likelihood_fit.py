"""`fit_likelihood`: a `LikelihoodModel` from clean moments and the same ones attacked."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import optimize, special

from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats
from avsec_gym.validation.evidence import evidence_scopes
from avsec_gym.validation.fitted_on import FittedOn
from avsec_gym.validation.maximum_likelihood import (
    PATTERNS,
    LikelihoodModel,
    element_patterns,
)
from avsec_gym.validation.normal_scores import fit_normal_scores
from avsec_gym.validation.state_posterior import States, state_indices, state_vectors

FOLDS = 5
"""A fit holds out one of so many parts at a time, and needs as many drives."""
_DEGREES_OF_FREEDOM = (3.0, 5.0, 10.0, 30.0, 100.0)
_EXPONENTS, _OFFSETS = (0.05, 1.5), (-5.0, 5.0)
_FINEST = 0.1
"""Of u; nothing is more exact: keeps elements that never vary from being certain."""


@dataclass(frozen=True, eq=False)
class LikelihoodSamples:
    """Moments whose state is known.

    Args:
        evidence: Shares, shape (N, M); see `gather_evidence`.
        states: **s**, shape (N, n + 1).
        frames: Which moment of the world each sample shows, clean or attacked, shape (N,).
        drives: Which drive its moment belongs to, shape (N,); moments of one drive are alike.
            None: each is of a drive of its own.

    Raises:
        ConfigurationError: Lengths differ, a moment has no clean sample, or is of two drives.
    """

    evidence: Floats
    states: States
    frames: NDArray[np.intp]
    drives: NDArray[np.intp] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "evidence", np.asarray(self.evidence, float))
        object.__setattr__(self, "states", np.asarray(self.states, bool))
        object.__setattr__(self, "frames", np.unique(self.frames, return_inverse=True)[1])
        drives = self.frames if self.drives is None else self.drives
        object.__setattr__(self, "drives", np.unique(drives, return_inverse=True)[1])
        if len({len(self.evidence), len(self.states), len(self.frames), len(drives)}) > 1:
            raise ConfigurationError("evidence, states, frames, drives: a row for each sample")
        if len(np.unique([self.frames, self.drives], axis=1).T) > len(np.unique(self.frames)):
            raise ConfigurationError("a moment belongs to one drive")
        clean = np.unique(self.frames[~self.states.any(axis=1)])
        if not len(clean) or len(clean) < len(np.unique(self.frames)):
            raise ConfigurationError(
                f"each moment needs a clean sample, {len(clean)} of "
                f"{len(np.unique(self.frames))} have one"
            )

    def of_frames(self, chosen: NDArray[np.bool_]) -> LikelihoodSamples:
        """Those of some moments.

        Args:
            chosen: Shape (moments,).
        """
        return self._of(chosen[self.frames])

    def in_folds(self) -> Iterator[tuple[LikelihoodSamples, NDArray[np.intp]]]:
        """All samples but a fifth, and which ones that fifth is: drives are never divided."""
        drives = np.asarray(self.drives)
        sizes = np.bincount(drives)
        fold, filled = np.empty(len(sizes), int), np.zeros(FOLDS)
        # The longest drives first, each to the fold that has least.
        for drive in np.argsort(-sizes, kind="stable"):
            fold[drive] = filled.argmin()
            filled[fold[drive]] += sizes[drive]
        for number in range(FOLDS):
            held_out = fold[drives] == number
            yield self._of(~held_out), np.flatnonzero(held_out)

    def _of(self, kept: NDArray[np.bool_]) -> LikelihoodSamples:
        drives = np.asarray(self.drives)[kept]
        return LikelihoodSamples(self.evidence[kept], self.states[kept], self.frames[kept], drives)


def fit_likelihood(on: FittedOn, samples: LikelihoodSamples) -> LikelihoodModel:
    """Fit how evidence looks, tails and exponent; then false alarms, on drives that were held out.

    Each fifth of the drives is judged by what was fitted on the others.  How heavy the tails are,
    and how much the likelihood is tempered, is what makes the true states of held-out samples most
    probable.  Sizes and seeds of the attacks should not be those that are to be judged.

    Args:
        on: The sensors, the depth and the data.
        samples: Clean and attacked.

    Raises:
        ConfigurationError: Fewer than ten moments or five drives; or of some element no sample
            shows some of its sensors attacked together, which the model can only learn from
            samples.
    """
    moments, drives = len(np.unique(samples.frames)), len(np.unique(np.asarray(samples.drives)))
    if moments < 2 * FOLDS or drives < FOLDS:
        raise ConfigurationError(
            f"a fit needs {2 * FOLDS} moments or more of {FOLDS} drives or more, got {moments} of "
            f"{drives}"
        )
    truth = state_indices(samples.states)
    parts = [(_fit_moments(on, part), held_out) for part, held_out in samples.in_folds()]
    calibration = _calibration(parts, samples.evidence, truth)
    scores, distances = np.empty((2, len(truth)))
    for model, held_out in parts:
        judged = _calibrated(model, **calibration)
        scores[held_out] = judged.alarm_scores(samples.evidence[held_out])
        distances[held_out] = judged.distances(samples.evidence[held_out])
    farthest = np.zeros(moments)
    np.maximum.at(farthest, samples.frames, distances)
    clean = truth == 0
    return replace(
        _calibrated(_fit_moments(on, samples), **calibration),
        clean_scores=scores[clean],
        farthest=farthest[samples.frames[clean]],
    )


def _fit_moments(on: FittedOn, samples: LikelihoodSamples) -> LikelihoodModel:
    """Means, deviations and correlations."""
    scale = fit_normal_scores(samples.evidence[~samples.states.any(axis=1)])
    u = scale(samples.evidence)
    scopes = evidence_scopes(on.system)
    patterns = element_patterns(samples.states, scopes)
    mean, deviation = np.zeros((len(scopes), PATTERNS)), np.ones((len(scopes), PATTERNS))
    residuals = np.zeros_like(u)
    for element, scope in enumerate(scopes):
        for pattern in range(2 ** len(scope)):
            shown = patterns[:, element] == pattern
            if shown.sum() < 2:
                attacked = [s for bit, s in enumerate(scope) if pattern >> bit & 1]
                raise ConfigurationError(
                    f"of the sensors {scope} no two samples show {attacked} attacked: add some"
                )
            seen = u[shown, element]
            mean[element, pattern] = seen.mean()
            # Clean scores deviate by 1, unless most are equal, and then the others by more.
            deviation[element, pattern] = max(seen.std(), _FINEST if pattern else 1.0)
            residuals[shown, element] = (seen - seen.mean()) / deviation[element, pattern]
    return LikelihoodModel(
        on,
        mean,
        deviation,
        _correlation(residuals, patterns > 0, len(np.unique(samples.frames))),
        u.min(axis=0),
        u.max(axis=0),
        _DEGREES_OF_FREEDOM[0],
        scale=scale,
    )


def _calibrated(
    model: LikelihoodModel, degrees_of_freedom: float, exponent: float, offset: float
) -> LikelihoodModel:
    return replace(model, degrees_of_freedom=degrees_of_freedom, exponent=exponent, offset=offset)


def _correlation(residuals: Floats, touched: NDArray[np.bool_], moments: int) -> Floats:
    """By whether two elements are touched, shape (2, 2, M, M); see `LikelihoodModel`.

    As if as many moments without any correlation had been seen as there are elements.
    """
    m = residuals.shape[1]
    result = np.empty((2, 2, m, m))
    for first, second in np.ndindex(2, 2):
        rows, columns = touched == bool(first), touched == bool(second)
        together = rows.T.astype(float) @ columns
        found = (residuals * rows).T @ (residuals * columns) / np.maximum(together, 1.0)
        result[first, second] = found * moments / (m + moments)
        np.fill_diagonal(result[first, second], 1.0)
    return result


def _calibration(
    parts: list[tuple[LikelihoodModel, NDArray[np.intp]]], evidence: Floats, truth: NDArray[np.intp]
) -> dict[str, float]:
    """Degrees of freedom, exponent and offset that make the true held-out states most probable.

    Args:
        parts: Models, and the samples that each has not seen.
        evidence: Of all samples.
        truth: Indices of their states; how often they occur is the prior here.
    """
    sensors = parts[0][0].sensors
    attacked = state_vectors(sensors).sum(axis=1)
    with np.errstate(divide="ignore"):
        prior = np.log(np.bincount(truth, minlength=2**sensors) / len(truth))
    found = []
    for freedom in _DEGREES_OF_FREEDOM:
        scores = np.empty((len(truth), 2**sensors))
        for model, held_out in parts:
            judge = replace(model, degrees_of_freedom=freedom)
            scores[held_out] = judge.log_likelihoods(evidence[held_out])

        def surprise(parameters: Floats, scores: Floats = scores) -> float:
            exponent, offset = parameters
            weighed = special.log_softmax(exponent * scores + offset * attacked + prior, axis=1)
            return -float(weighed[np.arange(len(truth)), truth].mean())

        best = optimize.minimize(
            surprise, (1.0, 0.0), method="Nelder-Mead", bounds=(_EXPONENTS, _OFFSETS)
        )
        found.append((float(best.fun), freedom, *map(float, best.x)))
    return dict(zip(("degrees_of_freedom", "exponent", "offset"), min(found)[1:], strict=True))
