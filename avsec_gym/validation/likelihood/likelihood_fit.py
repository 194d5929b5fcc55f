"""`fit_likelihood`: a `LikelihoodModel` from clean frames and the same ones attacked."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, optimize, special, stats

from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats
from avsec_gym.validation.evidence.evidence import evidence_scopes
from avsec_gym.validation.fitted_on import FittedOn
from avsec_gym.validation.likelihood.maximum_likelihood import LikelihoodModel
from avsec_gym.validation.likelihood.normal_scores import fit_normal_scores
from avsec_gym.validation.likelihood.score_densities import (
    LEAST_SCORE,
    PATTERNS,
    SCORES,
    STEP,
    as_normal,
    element_patterns,
)
from avsec_gym.validation.state_posterior import (
    States,
    attack_prior,
    state_indices,
    state_vectors,
)

FOLDS = 5
"""A fit holds out one of so many parts at a time, and needs as many drives."""
_WEIGHTS, _OFFSETS = (0.0, 3.0), (-8.0, 8.0)
_USUAL_WEIGHT = 0.5
"""The weight of a term, as far as nothing else is learned."""
_FINEST = 0.2
"""The finest step of u; nothing is more exact."""
_UNSEEN = 0.02
"""Share of a density that is for what no sample shows: of clean frames the normal distribution, of
attacked ones one that is twice as wide as they are."""
_LEAST_DENSITY = -50.0
"""Its logarithm."""
_MOST_TERMS = 100_000_000
"""The most terms that weights are learned from, so that memory suffices: of some of the samples if
need be."""


@dataclass(frozen=True, eq=False)
class LikelihoodSamples:
    """Frames whose state is known.

    Args:
        evidence: Shares, shape (N, M); see `gather_evidence`.
        states: **s**, shape (N, n + 1).
        frames: Frame of the world that each sample shows, clean or attacked, shape (N,).
        drives: Drive of each sample's frame, shape (N,); frames of one drive are alike.
            None: each is of a drive of its own.

    Raises:
        ConfigurationError: Lengths differ, a frame has no clean sample, or is of two drives.
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
            raise ConfigurationError("a frame belongs to one drive")
        clean = np.unique(self.frames[~self.states.any(axis=1)])
        if not len(clean) or len(clean) < len(np.unique(self.frames)):
            raise ConfigurationError(
                f"each frame needs a clean sample, {len(clean)} of "
                f"{len(np.unique(self.frames))} have one"
            )

    def of_frames(self, chosen: NDArray[np.bool_]) -> LikelihoodSamples:
        """The samples of some frames.

        Args:
            chosen: Whether each frame is chosen, shape (frames,).
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
    """Fit how evidence looks; then weights and false alarms, on drives that were held out.

    Each fifth of the drives is judged by what was fitted on the others.  Weights are those that
    make the true states of held-out samples most probable, each state as often as `attack_prior`
    expects it, so that probabilities are calibrated.  Sizes and seeds of the attacks should not be
    those that are to be judged.

    Args:
        on: The sensors, the depth and the data.
        samples: Clean and attacked.

    Raises:
        ConfigurationError: Fewer than ten frames or five drives; or of some element no sample
            shows some of its sensors attacked together, which the model can only learn from
            samples.
    """
    frames, drives = len(np.unique(samples.frames)), len(np.unique(np.asarray(samples.drives)))
    if frames < 2 * FOLDS or drives < FOLDS:
        raise ConfigurationError(
            f"a fit needs {2 * FOLDS} frames or more of {FOLDS} drives or more, got {frames} of "
            f"{drives}"
        )
    truth = state_indices(samples.states)
    # Densities are fitted without one fifth of the drives at a time; weights on that fifth.
    parts = [(_densities(on, part), held_out) for part, held_out in samples.in_folds()]
    weighed = _weights(parts, samples.evidence, truth)
    # Alarm scores and strangeness of every sample, by the model that has not seen it.
    scores, strangeness = np.empty((2, len(truth)))
    for model, held_out in parts:
        judged = replace(model, **weighed)
        scores[held_out] = judged.alarm_scores(samples.evidence[held_out])
        strangeness[held_out] = judged.strangeness(samples.evidence[held_out])
    # A frame is as strange as the strangest of its states.
    strangest = np.full(frames, -np.inf)
    np.maximum.at(strangest, samples.frames, strangeness)
    clean = truth == 0
    # The model itself has the densities of all drives.
    return replace(
        _densities(on, samples),
        **weighed,
        clean_scores=scores[clean],
        strangest=strangest[samples.frames[clean]],
    )


def _densities(on: FittedOn, samples: LikelihoodSamples) -> LikelihoodModel:
    """Densities and correlations, all of one weight."""
    scale = fit_normal_scores(samples.evidence[~samples.states.any(axis=1)])
    u = scale(samples.evidence)
    scopes = evidence_scopes(on.system)
    patterns = element_patterns(samples.states, scopes)
    log_density = np.zeros((len(scopes), PATTERNS, SCORES))
    z = np.zeros_like(u)
    for element, scope in enumerate(scopes):
        for pattern in range(2 ** len(scope)):
            shown = patterns[:, element] == pattern
            if shown.sum() < 2:
                attacked = [s for bit, s in enumerate(scope) if pattern >> bit & 1]
                raise ConfigurationError(
                    f"of the sensors {scope} no two samples show {attacked} attacked: add some"
                )
            seen = u[shown, element]
            found = _log_density(seen, clean=pattern == 0)
            log_density[element, pattern] = found
            z[shown, element] = np.interp(seen, _GRID, as_normal(found))
    return LikelihoodModel(
        on,
        log_density,
        _correlation(z, patterns > 0, len(np.unique(samples.frames))),
        u.min(axis=0),
        u.max(axis=0),
        np.full(len(scopes) + 1, _USUAL_WEIGHT),
        scale=scale,
    )


def _log_density(seen: Floats, *, clean: bool) -> Floats:
    """A kernel estimate, Silverman's, at all scores, shape (SCORES,).

    Args:
        seen: Scores u, shape (any,).
        clean: Whether the samples are without an attack.
    """
    spread = seen.std()
    quartiles = np.subtract(*np.quantile(seen, (0.75, 0.25))) / 1.34
    width = 0.9 * min(spread, quartiles or spread) * len(seen) ** -0.2
    counts = np.histogram(seen, _BINS)[0] / (len(seen) * STEP)
    kernels = ndimage.gaussian_filter1d(counts, max(width, _FINEST) / STEP, mode="constant")
    middle, wide = (0.0, 1.0) if clean else (seen.mean(), 2.0 * spread + 0.5)
    density = (1.0 - _UNSEEN) * kernels + _UNSEEN * stats.norm.pdf(_GRID, middle, wide)
    with np.errstate(divide="ignore"):
        logarithm = np.log(density / (density.sum() * STEP))
    # Rounded, for files.
    return np.asarray(np.round(np.maximum(logarithm, _LEAST_DENSITY), 4))


def _correlation(residuals: Floats, touched: NDArray[np.bool_], frames: int) -> Floats:
    """By whether two elements are touched, shape (2, 2, M, M); see `LikelihoodModel`.

    As if as many frames without any correlation had been seen as there are elements.
    """
    m = residuals.shape[1]
    result = np.empty((2, 2, m, m))
    for first, second in np.ndindex(2, 2):
        rows, columns = touched == bool(first), touched == bool(second)
        together = rows.T.astype(float) @ columns
        found = (residuals * rows).T @ (residuals * columns) / np.maximum(together, 1.0)
        result[first, second] = found * frames / (m + frames)
        np.fill_diagonal(result[first, second], 1.0)
    return result


def _weights(
    parts: list[tuple[LikelihoodModel, NDArray[np.intp]]], evidence: Floats, truth: NDArray[np.intp]
) -> dict[str, Any]:
    """Weights and offset that make the true held-out states most probable.

    Args:
        parts: Models, and the samples that each has not seen.
        evidence: The evidence of all samples.
        truth: Indices of their states, which count as often as `attack_prior` expects them.
    """
    # Samples count as often as the prior expects their states.
    model = parts[0][0]
    states = state_vectors(model.sensors)
    shown = np.bincount(truth, minlength=len(states)) / len(truth)
    expected = np.where(shown > 0, attack_prior(model.sensors), 0.0)
    with np.errstate(divide="ignore"):
        prior = np.log(expected / expected.sum())
    # The terms of held-out samples; of some of them where memory would not suffice.
    few = max(1, _MOST_TERMS // (len(states) * len(model.weights)))
    chosen = np.sort(np.random.default_rng(0).permutation(len(truth))[:few])
    terms = np.empty((len(chosen), len(states), len(model.weights) + 1))
    for judge, held_out in parts:
        own = np.isin(chosen, held_out)
        terms[own, :, :-1] = judge.terms(evidence[chosen[own]])
    terms[..., -1] = states.sum(axis=1)
    true = terms[np.arange(len(chosen)), truth[chosen]]
    counts = np.exp(prior[truth[chosen]]) / shown[truth[chosen]]
    usual = np.r_[np.full(len(model.weights), _USUAL_WEIGHT), 0.0]

    # Minus the log-probability of the true states, with a quadratic prior around the usual weights.
    def surprise(weights: Floats) -> tuple[float, Floats]:
        weighed = terms @ weights + prior
        missed = special.logsumexp(weighed, axis=1) - true @ weights - prior[truth[chosen]]
        believed = np.einsum("ns,nsk->nk", special.softmax(weighed, axis=1), terms)
        away = weights - usual
        return (
            float(counts @ missed + 0.5 * away @ away) / len(chosen),
            (counts @ (believed - true) + away) / len(chosen),
        )

    bounds = [_WEIGHTS] * len(model.weights) + [_OFFSETS]
    found = optimize.minimize(surprise, usual, jac=True, method="L-BFGS-B", bounds=bounds).x
    weights, (offset,) = np.split(found, [len(model.weights)])
    return {"weights": weights, "offset": float(offset)}


_GRID = LEAST_SCORE + STEP * np.arange(SCORES)
_BINS = np.r_[_GRID - 0.5 * STEP, _GRID[-1] + 0.5 * STEP]
