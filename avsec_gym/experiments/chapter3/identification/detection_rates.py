"""Is an attack on one of three sensors detected?  The two systems of section 3.3."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from avsec_gym.experiments.chapter3.identification.evidence_table import EvidenceTable
from avsec_gym.experiments.chapter3.settings import RATES, SCENARIOS
from avsec_gym.experiments.json_rows import FLAT
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.sensor_system import Triple
from avsec_gym.validation.fitted_on import FittedOn
from avsec_gym.validation.state_posterior import States, state_vectors
from avsec_gym.validation.thresholds import Criterion, ThresholdTable


def exceeded(
    fitted: EvidenceTable,
    judged: EvidenceTable,
    on: FittedOn,
    rate: float,
    criterion: Criterion = "any",
) -> NDArray[np.bool_]:
    """e_{i,j,k} of all judged frames, shape (N, states, triples).

    Args:
        fitted: The frames whose clean states give the thresholds.
        judged: Other frames.
        on: The sensors and the depth that the thresholds hold for.
        rate: The designated false alarm rate r.
        criterion: What counts as beyond, see `ThresholdTable.thresholds`.
    """
    chosen = ThresholdTable(on, fitted.measures[:, 0]).thresholds(rate, criterion)
    thresholds = np.array([chosen[triple].shares for triple in on.system.triples])
    return np.asarray((judged.measures > thresholds).any(axis=-1))


@dataclass(frozen=True)
class CaseRates:
    """How often an alarm is raised.

    Args:
        cases: The share by the attacked sensors (`case_name`) of frames with an alarm.
        average: The mean of all cases.
        interval: The rate's 95 % interval.
        false_alarms: The alarms on clean frames.
    """

    cases: Mapping[str, float]
    average: float | None
    interval: Sequence[float] | None
    false_alarms: Share


@dataclass(frozen=True)
class DetectionRateRow:
    """How often a system of three sensors detects an attack.

    Args:
        scenario: The system, one of `SCENARIOS`.
        rate: The designated false alarm rate r.
        criterion: The shares that count.
        rates: The rates of alarms.
    """

    scenario: str
    rate: float
    criterion: Criterion
    rates: CaseRates = field(metadata=FLAT)


def detection_rates(
    fitted: EvidenceTable,
    judged: EvidenceTable,
    on: FittedOn,
    criterion: Criterion = "any",
    rates: Sequence[float] = RATES,
) -> list[DetectionRateRow]:
    """The share of attacks detected in every case and on average, for each scenario and r.

    Args:
        fitted: The frames whose clean states give the thresholds.
        judged: Other frames, whose attacks are to be detected.
        on: The sensors and the depth that the thresholds hold for.
        criterion: What counts as beyond, see `ThresholdTable.thresholds`.
        rates: The values of r.
    """
    rows = []
    for rate in rates:
        state_vector = exceeded(fitted, judged, on, rate, criterion)
        for name, triple in SCENARIOS.items():
            column = on.system.triples.index(triple)
            alarms = state_vector[:, :, column]
            cases = attack_cases_of(triple, len(on.system))
            found = case_rates(alarms, cases, judged.drives)
            rows.append(DetectionRateRow(name, rate, criterion, found))
    return rows


def case_rates(
    alarms: NDArray[np.bool_], cases: Mapping[int, tuple[int, ...]], drives: Sequence[str]
) -> CaseRates:
    """How often an alarm is raised in each attack case, on average, and on clean frames.

    Args:
        alarms: The alarms of N frames in all states, shape (N, states).
        cases: The sets of attacked sensors by state, see `attack_cases_of`.
        drives: The drive of each frame.
    """
    average = share_of(alarms[:, list(cases)], drives)
    return CaseRates(
        {case_name(case): float(alarms[:, state].mean()) for state, case in cases.items()},
        average.rate,
        average.interval,
        share_of(alarms[:, 0], drives),
    )


def case_name(attacked: Iterable[int]) -> str:
    """``S0+S2``."""
    return "+".join(f"S{sensor}" for sensor in attacked)


def attack_cases_of(triple: Triple, sensors: int) -> dict[int, tuple[int, ...]]:
    """The seven states in which only sensors of a triple are attacked: index -> the attacked."""
    states = state_vectors(sensors)
    cases = {}
    for index, state in enumerate(states):
        attacked = tuple(np.flatnonzero(state).tolist())
        if attacked and set(attacked) <= set(triple):
            cases[index] = attacked
    return cases


def at_most(states: States, attacked: int) -> NDArray[np.intp]:
    """Indices of the states with one attacked sensor or more, up to a number."""
    count = states.sum(axis=1)
    return np.flatnonzero((count > 0) & (count <= attacked))
