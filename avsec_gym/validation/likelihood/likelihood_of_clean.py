"""`likelihood_of_clean`: a likelihood model from clean frames and nothing else."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from avsec_gym.attacks.attack import Seed
from avsec_gym.attacks.attacks_to_fit_on import attack_to_fit_on, attacked_in_turn
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats
from avsec_gym.sensor_system import SensorSystem
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.evidence.state_evidence import StateEvidence
from avsec_gym.validation.fitted_on import FittedOn
from avsec_gym.validation.likelihood.likelihood_fit import FOLDS, LikelihoodSamples, fit_likelihood
from avsec_gym.validation.likelihood.maximum_likelihood import LikelihoodModel
from avsec_gym.validation.state_posterior import state_vectors

_STRETCHES = 2 * FOLDS
"""The number of stretches into which frames are cut that come from too few drives."""


def evidence_of_all_states(
    frame: SensorFrame, system: SensorSystem, depth: PairDepth, seed: Seed
) -> Floats:
    """The evidence of a clean frame in every state, had any of the sensors been attacked.

    Args:
        frame: A frame without an attack.
        system: The sensors.
        depth: How disparities of two cameras are found.
        seed: Seed of the attacks, which are those of `attack_to_fit_on`.

    Returns:
        In the order of `state_vectors` and of `evidence_elements`, shape (2^(n+1), M).

    Raises:
        ConfigurationError: The cameras do not stand from right to left.
        DataError: The frame lacks a sensor, or its file is broken.
    """
    attack_of = partial(attack_to_fit_on, reference=system.reference)
    tampered = attacked_in_turn(frame, system, attack_of, seed)
    frames = {sensor: attacked.frame for sensor, attacked in tampered.items()}
    return StateEvidence(frame, frames, system, depth).evidence(state_vectors(len(system)))


def likelihood_of_clean(on: FittedOn, evidence: Floats, drives: Sequence[str]) -> LikelihoodModel:
    """Fit a model on frames in all states.

    Args:
        on: The sensors, the depth and the data.
        evidence: Evidence as of `evidence_of_all_states`, in the order in which the frames were
            recorded, shape (N, 2^(n+1), M).
        drives: The drive that each frame belongs to.  Fewer than five cannot be held out one after
            the other: they are cut into ten stretches, at whose ends frames are alike, so that
            somewhat more false alarms are to be expected than r.

    Raises:
        ConfigurationError: Fewer than ten frames.
    """
    states = state_vectors(len(on.system))
    numbers = np.unique(drives, return_inverse=True)[1] if len(drives) else np.zeros(0, int)
    if len(set(drives)) < FOLDS:
        numbers = np.arange(len(drives)) * _STRETCHES // max(len(drives), 1)
    each = len(states)
    return fit_likelihood(
        on,
        LikelihoodSamples(
            np.reshape(evidence, (len(drives) * each, -1)),
            np.tile(states, (len(drives), 1)),
            np.repeat(np.arange(len(drives)), each),
            np.repeat(numbers, each),
        ),
    )
