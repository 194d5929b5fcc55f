"""Calibration of the likelihood validator: how often its statuses and probabilities are right."""

from __future__ import annotations

from typing import Any

import numpy as np

from avsec_gym.experiments.chapter3.identification.evidence_table import EvidenceTable
from avsec_gym.geometry import Floats
from avsec_gym.metrics.clustered_shares import share_of
from avsec_gym.metrics.intervals import wilson_interval
from avsec_gym.validation.likelihood.likelihood_validator import LikelihoodValidator
from avsec_gym.validation.likelihood.maximum_likelihood import LikelihoodModel
from avsec_gym.validation.state_posterior import (
    SensorStatus,
    attack_prior,
    brier_score,
    reliability,
    state_vectors,
)


def calibration(model: LikelihoodModel, judged: EvidenceTable) -> dict[str, Any]:
    """How often `LikelihoodValidator` is right, by its default rule, rate and prior.

    Args:
        model: A model that was fitted on other frames.
        judged: The judged frames, in all states.

    Returns:
        ``rate``, ``certainty``; ``statuses``: for each number of attacked sensors, by its text, the
        shares of the statuses on all sensors that are ``right``, ``wrong`` and ``cannot_tell``,
        and of the frames in which ``all_right`` are, and with ``alarms``.  Of the probabilities,
        with every state as often as the prior expects it: ``brier``; ``reliability``, for each
        tenth of probability what was ``predicted`` on average, the share that was ``observed`` with
        its ``interval``, as if drives were independent, and the share of the ``sensors`` in it;
        ``calibration_error``, how far both are from each other on average (Naeini 2015).
        ``all_alike`` has the same of a prior by which every state is equally probable, most of
        them beyond n - 2.
    """
    states, drives = state_vectors(model.sensors), judged.drives
    frames = len(judged)
    rate, certainty = LikelihoodValidator.rate, LikelihoodValidator.certainty
    decoding = model.decode(judged.shares.reshape(frames * len(states), -1), rate)
    reported = np.array(decoding.statuses(certainty)).reshape(frames, len(states), -1)
    alarms = decoding.alarms.reshape(frames, len(states))
    unknown = reported == SensorStatus.CANNOT_TELL
    right = reported == np.where(states, SensorStatus.ATTACKED, SensorStatus.SOUND)
    statuses = {}
    for count in range(model.sensors + 1):
        chosen = np.flatnonzero(states.sum(axis=1) == count)
        statuses[str(count)] = {
            "right": share_of(right[:, chosen], drives),
            "wrong": share_of(~(right | unknown)[:, chosen], drives),
            "cannot_tell": share_of(unknown[:, chosen], drives),
            "all_right": share_of(right[:, chosen].all(axis=2), drives),
            "alarms": share_of(alarms[:, chosen], drives),
        }
    return {
        "rate": rate,
        "certainty": certainty,
        "statuses": statuses,
        **_of_probabilities(model, judged, attack_prior(model.sensors)),
        "all_alike": _of_probabilities(model, judged, np.full(len(states), 1 / len(states))),
    }


def _of_probabilities(
    model: LikelihoodModel, judged: EvidenceTable, prior: Floats
) -> dict[str, Any]:
    """``brier``, ``reliability``, ``calibration_error``, with states as often as a prior states."""
    states, frames = state_vectors(model.sensors), len(judged)
    posterior = model.posterior(judged.shares.reshape(frames * len(states), -1), prior)
    truth = np.tile(states, (frames, 1))
    weights = np.tile(prior, frames)
    rows = reliability(posterior, truth, weights, np.repeat(judged.drives, len(states)))
    filled = rows[np.isfinite(rows).all(axis=1)]
    off = np.abs(filled[:, 0] - filled[:, 1])
    return {
        "brier": brier_score(posterior, truth, weights),
        "calibration_error": float(np.average(off, weights=filled[:, 2])),
        "reliability": [
            {
                "predicted": mean,
                "observed": share,
                "interval": list(wilson_interval(share * independent, independent)),
                "sensors": weight / np.nansum(rows[:, 2]),
            }
            for mean, share, weight, independent in filled.tolist()
        ],
    }
