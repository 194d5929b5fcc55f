"""Which sensor is attacked?  Algorithm 2 against maximum likelihood (section 3.4 and beyond)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avsec_gym.experiments.chapter3.detection_rates import RATES, at_most, exceeded
from avsec_gym.experiments.chapter3.evidence_table import EvidenceTable
from avsec_gym.experiments.chapter3.shares import share_of
from avsec_gym.validation.fitted_on import FittedOn
from avsec_gym.validation.identification import identify_attacked_sensors
from avsec_gym.validation.likelihood_of_clean import likelihood_of_clean
from avsec_gym.validation.maximum_likelihood import LikelihoodModel
from avsec_gym.validation.state_posterior import state_vectors
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
    return likelihood_of_clean(on, fitted.shares, fitted.drives)


def maximum_likelihood(model: LikelihoodModel, judged: EvidenceTable, rate: float) -> Found:
    """What the most probable state vector is, of every judged moment in every state."""
    decoding = model.decode(judged.shares.reshape(-1, judged.shares.shape[2]), rate)
    return decoding.states.reshape(*judged.shares.shape[:2], -1)


def identification_rates(
    conclude: Callable[[float], Found],
    drives: Sequence[str],
    sensors: int,
    rates: Sequence[float] = RATES,
) -> list[dict[str, Any]]:
    """For each r the share of moments in which exactly the attacked sensors were named.

    Args:
        conclude: What is found at r.
        drives: Of the judged moments.
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
        average = share_of(exact[:, within], drives)
        rows.append(
            {
                "rate": rate,
                "sensors": {
                    f"S{one}": share_of(exact[:, 1 << one], drives) for one in range(sensors)
                },
                "average": average["rate"],
                "interval": average["interval"],
                "beyond": share_of(exact[:, beyond], drives),
                "false_alarms": share_of(found[:, 0].any(axis=1), drives),
            }
        )
    return rows
