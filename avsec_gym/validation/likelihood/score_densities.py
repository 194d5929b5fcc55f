"""Densities of evidence: tables over scores u, by which sensors of an element are attacked."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import special

from avsec_gym.geometry import Floats
from avsec_gym.validation.evidence.evidence import Scope
from avsec_gym.validation.state_posterior import States

PATTERNS = 8
"""Patterns in which the three sensors of a triple can be attacked or not."""
LEAST_SCORE, STEP, SCORES = -9.0, 0.1, 311
"""Where densities are known: the first score u, from one to the next, and how many."""
_LEAST_EIGENVALUE = 0.02
"""Least eigenvalue of a correlation matrix that was put together from pairs."""
_LEAST_CHANCE = 1e-9
"""The chance beyond which nothing is farther out."""


def element_patterns(states: States, scopes: Sequence[Scope]) -> NDArray[np.intp]:
    """Which of its own sensors are attacked, for each element of the evidence.

    Args:
        states: The states, shape (N, n + 1).
        scopes: The scopes of the M elements.

    Returns:
        The attacked sensors of the scope as bits, the first one lowest, shape (N, M).
    """
    return np.stack([states[:, scope] @ (1 << np.arange(len(scope))) for scope in scopes], axis=1)


def as_normal(log_density: Floats) -> Floats:
    """Scores that are as far out in a normal distribution as each u is by its density.

    Args:
        log_density: Log-densities at all u, shape (..., SCORES).

    Returns:
        The same shape.
    """
    density = np.exp(log_density)
    # Half of a step's chance lies on either side of its middle.
    below = np.cumsum(density, axis=-1) - 0.5 * density
    chance = below / density.sum(axis=-1, keepdims=True)
    return np.asarray(special.ndtri(np.clip(chance, _LEAST_CHANCE, 1.0 - _LEAST_CHANCE)))


def interpolated(u: Floats, known: Floats) -> Floats:
    """What is known at `SCORES` scores at others, between which it is linear, shape (N, M, 8).

    Args:
        u: The scores, shape (N, M).
        known: The values at all `SCORES` scores, shape (M, 8, SCORES).
    """
    place = np.clip((u - LEAST_SCORE) / STEP, 0.0, SCORES - 1.0)
    below = np.minimum(place.astype(int), SCORES - 2)
    part = (place - below)[..., None]
    element = np.arange(known.shape[0])
    first, second = (known[element, :, below + step] for step in (0, 1))
    return np.asarray(first + part * (second - first))


def nearest_correlation(pairs: Floats) -> Floats:
    """A correlation matrix like what was put together from pairs, which may be none."""
    values, vectors = np.linalg.eigh(pairs)
    valid = (vectors * np.maximum(values, _LEAST_EIGENVALUE)) @ vectors.T
    scale = np.sqrt(np.diagonal(valid))
    return np.asarray(valid / np.outer(scale, scale))
