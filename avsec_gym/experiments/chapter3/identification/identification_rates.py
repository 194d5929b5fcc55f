"""Which sensor is attacked?  Algorithm 2 against maximum likelihood (section 3.4 and beyond)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.experiments.chapter3.identification.detection_rates import at_most, exceeded
from avsec_gym.experiments.chapter3.identification.evidence_table import EvidenceTable
from avsec_gym.experiments.chapter3.settings import RATES
from avsec_gym.experiments.json_rows import FLAT
from avsec_gym.geometry import Floats
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.validation.fitted_on import FittedOn
from avsec_gym.validation.identification import identify_attacked_sensors
from avsec_gym.validation.likelihood.likelihood_of_clean import likelihood_of_clean
from avsec_gym.validation.likelihood.likelihood_validator import LikelihoodValidator
from avsec_gym.validation.likelihood.maximum_likelihood import LikelihoodModel
from avsec_gym.validation.state_posterior import SensorStatus, state_vectors
from avsec_gym.validation.thresholds import Criterion

CRITERIA: tuple[Criterion, ...] = ("error", "any")
"""E alone, as in the thesis; and all shares of a triple."""


class Concluded(NamedTuple):
    """What was concluded of N frames in some states."""

    sensors: NDArray[np.bool_]
    """The sensor state vectors, shape (N, states, n + 1)."""
    reported: NDArray[np.bool_]
    """The sensors that the validator reports as attacked, the same shape: fewer, where it reports
    that their status is open."""
    alarms: NDArray[np.bool_]
    """Whether an attack is reported, perhaps without a named sensor, shape (N, states)."""


@dataclass(frozen=True)
class IdentificationRates:
    """How often exactly the attacked sensors are named.

    Args:
        rate: The designated false alarm rate r.
        sensors: Rates for an attack on each sensor alone, by its name.
        together: Rates by how many are attacked, as text, up to n - 2.
        average: The average over every set of up to n - 2 sensors.
        interval: The 95 % interval of `average`.
        reported: The same average of what the validator reports.
        beyond: The share over larger sets.
        false_alarms: The share of clean frames, whichever sensor is named.
    """

    rate: float
    sensors: Mapping[str, Share]
    together: Mapping[str, Share]
    average: float | None
    interval: Sequence[float] | None
    reported: Share
    beyond: Share
    false_alarms: Share


@dataclass(frozen=True)
class MethodRates:
    """The rates of one way to identify.

    Args:
        method: The way: algorithm 2 by a criterion, or maximum likelihood.
        rates: The method's rates.
    """

    method: str
    rates: IdentificationRates = field(metadata=FLAT)


def algorithm_2(
    fitted: EvidenceTable,
    judged: EvidenceTable,
    on: FittedOn,
    rate: float,
    criterion: Criterion = "any",
) -> Concluded:
    """What algorithm 2 concludes of every judged frame in every state.

    Both as the thesis states it, and as `ThresholdValidator` reports it: the validator names no
    sensor where no two sensors agree, and an error that no named sensor explains is an alarm, too.

    Args:
        fitted: The frames whose clean states give the thresholds.
        judged: Other frames.
        on: The sensors and the depth that the thresholds hold for.
        rate: The designated false alarm rate r.
        criterion: What counts as beyond, see `ThresholdTable.thresholds`.
    """
    state_vector = exceeded(fitted, judged, on, rate, criterion)
    sensors, triples = len(on.system), on.system.triples
    # Few vectors e differ from each other; each is decoded once.
    patterns, which = np.unique(state_vector.reshape(-1, len(triples)), axis=0, return_inverse=True)
    named, reported = np.zeros((2, len(patterns), sensors), bool)
    alarms = np.zeros(len(patterns), bool)
    for number, pattern in enumerate(patterns):
        e = dict(zip(triples, pattern.tolist(), strict=True))
        answer = identify_attacked_sensors(e.__getitem__, sensors)
        named[number, list(answer.attacked)] = True
        reported[number, list(answer.named)] = True
        alarms[number] = bool(answer.named or answer.doubtful)
    which = which.reshape(state_vector.shape[:2])
    return Concluded(named[which], reported[which], alarms[which])


def fitted_model(fitted: EvidenceTable, on: FittedOn) -> LikelihoodModel:
    """p(evidence | **s**) of every state of the fitted frames."""
    return likelihood_of_clean(on, fitted.shares, fitted.drives)


def maximum_likelihood(
    model: LikelihoodModel, judged: EvidenceTable, rate: float, prior: Floats | None = None
) -> Concluded:
    """What the most probable state vector is, of every judged frame in every state.

    And what `LikelihoodValidator` reports of it, by its default certainty.

    Args:
        model: The likelihood model.
        judged: The frames, in all states.
        rate: The designated false alarm rate r.
        prior: The probabilities of the states beforehand, see `LikelihoodModel.posterior`.
    """
    frames, states, elements = judged.shares.shape
    decoding = model.decode(judged.shares.reshape(-1, elements), rate, prior)
    statuses = np.array(decoding.statuses(LikelihoodValidator.certainty))
    return Concluded(
        decoding.states.reshape(frames, states, -1),
        (statuses == SensorStatus.ATTACKED).reshape(frames, states, -1),
        decoding.alarms.reshape(frames, states),
    )


def rates_of_methods(
    fitted: EvidenceTable,
    judged: EvidenceTable,
    on: FittedOn,
    model: LikelihoodModel,
    rates: Sequence[float],
) -> list[MethodRates]:
    """`identification_rates` of every way to identify.

    Args:
        fitted: The frames whose clean states give the thresholds.
        judged: Other frames.
        on: The sensors and the depth that thresholds and model hold for.
        model: The likelihood model that was fitted on the same frames.
        rates: The values of r.
    """
    methods: dict[str, Callable[[float], Concluded]] = {
        f"algorithm 2, {criterion}": partial(algorithm_2, fitted, judged, on, criterion=criterion)
        for criterion in CRITERIA
    }
    methods["maximum likelihood"] = partial(maximum_likelihood, model, judged)
    return [
        MethodRates(name, row)
        for name, conclude in methods.items()
        for row in identification_rates(conclude, judged.drives, len(on.system), rates)
    ]


def identification_rates(
    conclude: Callable[[float], Concluded],
    drives: Sequence[str],
    sensors: int,
    rates: Sequence[float] = RATES,
) -> list[IdentificationRates]:
    """The share of frames in which exactly the attacked sensors were named, for each r.

    Args:
        conclude: A function of r that gives what is concluded of all frames in all states.
        drives: The drive of each judged frame.
        sensors: The number of sensors, n + 1.
        rates: The values of r.
    """
    states = state_vectors(sensors)
    within, beyond = at_most(states, sensors - 3), at_most(states, sensors)
    beyond = np.setdiff1d(beyond, within)
    rows = []
    for rate in rates:
        found = conclude(rate)
        exact = (found.sensors == states).all(axis=2)
        reported = (found.reported == states).all(axis=2)
        average = share_of(exact[:, within], drives)
        rows.append(
            IdentificationRates(
                rate,
                sensors={
                    f"S{sensor}": share_of(exact[:, 1 << sensor], drives)
                    for sensor in range(sensors)
                },
                together={
                    str(count): share_of(exact[:, states.sum(axis=1) == count], drives)
                    for count in range(1, sensors - 2)
                },
                average=average.rate,
                interval=average.interval,
                reported=share_of(reported[:, within], drives),
                beyond=share_of(exact[:, beyond], drives),
                false_alarms=share_of(found.alarms[:, 0], drives),
            )
        )
    return rows
