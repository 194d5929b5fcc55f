"""Calibration of the likelihood validator: how often its statuses and probabilities are right."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from avsec_gym.experiments.chapter3.identification.evidence_table import EvidenceTable
from avsec_gym.experiments.json_rows import FLAT
from avsec_gym.geometry import Floats
from avsec_gym.metrics.clustered_shares import Share, effective_interval, share_of
from avsec_gym.validation.likelihood.likelihood_validator import LikelihoodValidator
from avsec_gym.validation.likelihood.maximum_likelihood import LikelihoodModel
from avsec_gym.validation.state_posterior import (
    SensorStatus,
    attack_prior,
    brier_score,
    reliability,
    state_vectors,
)


@dataclass(frozen=True)
class StatusShares:
    """How right the statuses are, of frames with so many attacked sensors.

    Args:
        right: The share of the statuses of all sensors.
        wrong: The share of the statuses of all sensors.
        cannot_tell: The share of the statuses of all sensors.
        all_right: The share of the frames with every status right.
        alarms: The share of the frames with an alarm.
    """

    right: Share
    wrong: Share
    cannot_tell: Share
    all_right: Share
    alarms: Share


@dataclass(frozen=True)
class ReliabilityPoint:
    """The sensors whose P(attacked) is within one tenth.

    Args:
        predicted: The mean of their probabilities.
        observed: The share of them that is attacked.
        interval: The 95 % interval of `observed`, as if drives were independent.
        sensors: The point's share of all sensors.
    """

    predicted: float
    observed: float
    interval: Sequence[float]
    sensors: float


@dataclass(frozen=True)
class ProbabilityCalibration:
    """How right probabilities are, with every state as often as a prior expects it.

    Args:
        brier: The Brier score.
        calibration_error: How far predictions and observations are from each other on average
            (Naeini 2015).
        reliability: Predictions and observations by tenths of probability.
    """

    brier: float
    calibration_error: float
    reliability: Sequence[ReliabilityPoint]


@dataclass(frozen=True)
class LikelihoodCalibration:
    """How often `LikelihoodValidator` is right.

    Args:
        rate: The method's designated false alarm rate r.
        certainty: The probability that a status needs.
        statuses: Shares by the number of attacked sensors, as text.
        probabilities: Probabilities by the prior as it comes.
        all_alike: Figures by a prior by which every state is equally probable, most of them beyond
            n - 2.
    """

    rate: float
    certainty: float
    statuses: Mapping[str, StatusShares]
    probabilities: ProbabilityCalibration = field(metadata=FLAT)
    all_alike: ProbabilityCalibration


def calibration(model: LikelihoodModel, judged: EvidenceTable) -> LikelihoodCalibration:
    """How often `LikelihoodValidator` is right, by its default rule, rate and prior.

    Args:
        model: A model that was fitted on other frames.
        judged: The judged frames, in all states.
    """
    states, drives = state_vectors(model.sensors), judged.drives
    frames = len(judged)
    rate, certainty = LikelihoodValidator.rate, LikelihoodValidator.certainty
    assert certainty is not None, "a default"
    decoding = model.decode(judged.shares.reshape(frames * len(states), -1), rate)
    reported = np.array(decoding.statuses(certainty)).reshape(frames, len(states), -1)
    alarms = decoding.alarms.reshape(frames, len(states))
    unknown = reported == SensorStatus.CANNOT_TELL
    right = reported == np.where(states, SensorStatus.ATTACKED, SensorStatus.SOUND)
    statuses = {}
    for count in range(model.sensors + 1):
        chosen = np.flatnonzero(states.sum(axis=1) == count)
        statuses[str(count)] = StatusShares(
            right=share_of(right[:, chosen], drives),
            wrong=share_of(~(right | unknown)[:, chosen], drives),
            cannot_tell=share_of(unknown[:, chosen], drives),
            all_right=share_of(right[:, chosen].all(axis=2), drives),
            alarms=share_of(alarms[:, chosen], drives),
        )
    return LikelihoodCalibration(
        rate,
        certainty,
        statuses,
        _of_probabilities(model, judged, attack_prior(model.sensors)),
        _of_probabilities(model, judged, np.full(len(states), 1 / len(states))),
    )


def _of_probabilities(
    model: LikelihoodModel, judged: EvidenceTable, prior: Floats
) -> ProbabilityCalibration:
    """With states as often as a prior expects them."""
    states, frames = state_vectors(model.sensors), len(judged)
    posterior = model.posterior(judged.shares.reshape(frames * len(states), -1), prior)
    truth = np.tile(states, (frames, 1))
    weights = np.tile(prior, frames)
    rows = reliability(posterior, truth, weights, np.repeat(judged.drives, len(states)))
    filled = rows[np.isfinite(rows).all(axis=1)]
    off = np.abs(filled[:, 0] - filled[:, 1])
    return ProbabilityCalibration(
        brier_score(posterior, truth, weights),
        float(np.average(off, weights=filled[:, 2])),
        [
            ReliabilityPoint(
                predicted=mean,
                observed=share,
                interval=list(effective_interval(share, independent)),
                sensors=weight / np.nansum(rows[:, 2]),
            )
            for mean, share, weight, independent in filled.tolist()
        ],
    )
