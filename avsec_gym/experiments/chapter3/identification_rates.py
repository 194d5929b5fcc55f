"""Which sensor is attacked?  Algorithm 2 against maximum likelihood (section 3.4 and beyond)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avsec_gym.experiments.chapter3.detection_rates import (
    RATES,
    at_most,
    exceeded,
    moment_interval,
    share_of,
)
from avsec_gym.experiments.chapter3.evidence_table import EvidenceTable
from avsec_gym.validation.fitted_on import FittedOn
from avsec_gym.validation.identification import identify_attacked_sensors
from avsec_gym.validation.likelihood_fit import LikelihoodSamples, fit_likelihood
from avsec_gym.validation.maximum_likelihood import LikelihoodModel
from avsec_gym.validation.state_posterior import (
    States,
    Verdict,
    brier_score,
    reliability,
    state_vectors,
)
from avsec_gym.validation.thresholds import Criterion

Found = NDArray[np.bool_]
"""Sensor state vectors that were concluded, shape (N, states, n + 1)."""


def algorithm_2(
    fitted: EvidenceTable,
    judged: EvidenceTable,
    on: FittedOn,
    rate: float,
    criterion: Criterion = "any",
) -> Found:
    """What algorithm 2 concludes of every judged moment in every state."""
    state_vector = exceeded(fitted, judged, on, rate, criterion)
    sensors, triples = len(on.system), on.system.triples
    # There are few different vectors e; each is decoded once.
    patterns, which = np.unique(state_vector.reshape(-1, len(triples)), axis=0, return_inverse=True)
    decoded = np.zeros((len(patterns), sensors), bool)
    for number, pattern in enumerate(patterns):
        e = dict(zip(triples, pattern.tolist(), strict=True))
        decoded[number, list(identify_attacked_sensors(e.__getitem__, sensors).attacked)] = True
    return np.asarray(decoded[which.ravel()].reshape(*state_vector.shape[:2], sensors))


def fitted_model(fitted: EvidenceTable, on: FittedOn) -> LikelihoodModel:
    """p(evidence | **s**) of every state of the fitted moments."""
    states = state_vectors(len(on.system))
    moments = len(fitted)
    return fit_likelihood(
        on,
        LikelihoodSamples(
            fitted.shares.reshape(moments * len(states), -1),
            np.tile(states, (moments, 1)),
            np.repeat(np.arange(moments), len(states)),
        ),
    )


def maximum_likelihood(model: LikelihoodModel, judged: EvidenceTable, rate: float) -> Found:
    """What the most probable state vector is, of every judged moment in every state."""
    decoding = model.decode(judged.shares.reshape(-1, judged.shares.shape[2]), rate)
    return decoding.states.reshape(*judged.shares.shape[:2], -1)


def identification_rates(
    conclude: Callable[[float], Found], sensors: int, rates: Sequence[float] = RATES
) -> list[dict[str, Any]]:
    """For each r the share of moments in which exactly the attacked sensors were named.

    Args:
        conclude: What is found at r.
        sensors: n + 1.
        rates: r.

    Returns:
        Rows with ``rate``; ``sensors``, the share for an attack on each alone; ``average`` over
        every set of up to n - 2 sensors, with ``interval``; ``beyond``, that over larger sets; and
        ``false_alarms`` on clean moments.
    """
    states = state_vectors(sensors)
    within, beyond = at_most(states, sensors - 3), at_most(states, sensors)
    beyond = np.setdiff1d(beyond, within)
    rows = []
    for rate in rates:
        found = conclude(rate)
        exact = (found == states).all(axis=2)
        rows.append(
            {
                "rate": rate,
                "sensors": {f"S{one}": share_of(exact[:, 1 << one]) for one in range(sensors)},
                "average": float(exact[:, within].mean()),
                "interval": moment_interval(exact[:, within]),
                "beyond": share_of(exact[:, beyond].ravel()),
                "false_alarms": share_of(np.asarray(found[:, 0].any(axis=1))),
            }
        )
    return rows


def honesty(model: LikelihoodModel, judged: EvidenceTable, rate: float = 0.01) -> dict[str, Any]:
    """Are the probabilities what they say, and how often is it said that one cannot tell?

    Over states drawn as the prior has them: half of the moments clean, the others in any state.
    """
    states = state_vectors(model.sensors)
    moments = len(judged)
    random = np.random.default_rng(0)
    drawn = np.where(random.random(moments) < 0.5, 0, random.integers(1, len(states), size=moments))
    truth: States = states[drawn]
    shares = judged.shares[np.arange(moments), drawn]
    prior = np.full(len(states), 0.5 / (len(states) - 1))
    prior[0] = 0.5
    decoding = model.decode(shares, rate, prior)
    verdicts = np.array(decoding.verdicts())
    told = verdicts != Verdict.CANNOT_TELL
    right = (verdicts == Verdict.ATTACKED) == truth
    return {
        "brier": brier_score(decoding.posterior, truth),
        "reliability": [
            None if np.isnan(row).any() else row.tolist()
            for row in reliability(decoding.posterior, truth)
        ],
        "told": share_of(told.ravel()),
        "right_where_told": share_of(right[told]),
        "right_by_attacked": {
            str(count): share_of(right[truth.sum(axis=1) == count].ravel())
            for count in range(model.sensors + 1)
            if (truth.sum(axis=1) == count).any()
        },
    }
