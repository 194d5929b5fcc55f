"""How often the object-level baseline detects an attack (thesis, table 3.1).

In a scenario the mismatches of its pairs are added up: the LiDAR with either camera, or all pairs
of three cameras.  The thesis does not state how many of them make an alarm.  That its baseline
detects less with the stricter IoU speaks for a number learned from clean data, as our thresholds
are; the other reading, that any mismatch is one, stands beside it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from avsec_gym.experiments.chapter3.identification.detection_rates import (
    CaseRates,
    attack_cases_of,
    case_rates,
)
from avsec_gym.experiments.chapter3.identification.summary import FEWEST
from avsec_gym.experiments.chapter3.objects.mismatch_counts import IOUS, mismatch_counts
from avsec_gym.experiments.chapter3.objects.score_thresholds import ScoreThreshold, score_thresholds
from avsec_gym.experiments.chapter3.recordings import FITTED, JUDGED, SYSTEM
from avsec_gym.experiments.chapter3.settings import RATES, SCENARIOS
from avsec_gym.experiments.json_rows import FLAT
from avsec_gym.geometry import Floats
from avsec_gym.runs.experiment import Configuration
from avsec_gym.runs.results import Results
from avsec_gym.sensor_system import SensorSystem, Triple
from avsec_gym.validation.evidence.disparity_maps import Pair
from avsec_gym.validation.recordings import drive_of
from avsec_gym.validation.state_posterior import state_vectors


@dataclass(frozen=True)
class BaselineRow:
    """How often mismatches of objects raise an alarm.

    Args:
        scenario: The system of three sensors, one of `SCENARIOS`.
        iou: The IoU that partners exceed.
        rate: The designated false alarm rate r; None: any mismatch raises an alarm.
        most: How many mismatches raise none.
        rates: The rates of alarms.
    """

    scenario: str
    iou: float
    rate: float | None
    most: int
    rates: CaseRates = field(metadata=FLAT)


@dataclass(frozen=True)
class BaselineSummary:
    """Detection rates of the baseline.

    Args:
        frames: The number of frames of each part.
        objects: The scores from which on boxes count, see `score_thresholds`.
        rows: The rates of `baseline_rates`.
    """

    frames: Mapping[str, int]
    objects: Mapping[str, ScoreThreshold]
    rows: Sequence[BaselineRow]


def baseline_summary(results: Results, configuration: Configuration) -> BaselineSummary | None:
    """Detection rates of the baseline; None where either part has fewer than `FEWEST` frames."""
    thresholds = score_thresholds(results, configuration.options)
    (fitted, _), (judged, frames) = (
        mismatch_counts(results, part, thresholds) for part in (FITTED, JUDGED)
    )
    counts = {FITTED: len(fitted), JUDGED: len(judged)}
    if min(counts.values()) < FEWEST:
        return None
    drives = [drive_of(id) for id in frames]
    rows = baseline_rates(fitted, judged, drives)
    return BaselineSummary(counts, thresholds, rows)


def baseline_rates(
    fitted: Floats, judged: Floats, drives: Sequence[str], system: SensorSystem = SYSTEM
) -> list[BaselineRow]:
    """The share of attacks detected in every case and on average, for each scenario, IoU and rule.

    Args:
        fitted: Mismatches of clean frames, shape (M, pairs, IoUs, 2, 2); the pairs are those of
            the system, the last axes whether its first and its second sensor is attacked.
        judged: The counts of other frames in all states, shape (N, pairs, IoUs, 2, 2).
        drives: The drive of each judged frame.
        system: A LiDAR and three cameras.
    """
    rows = []
    for name, triple in SCENARIOS.items():
        cases = attack_cases_of(triple, len(system))
        for column, iou in enumerate(IOUS):
            clean = _of_states(fitted[:, :, column], triple, system)[:, 0]
            counts = _of_states(judged[:, :, column], triple, system)
            for rate in (None, *RATES):
                most = 0 if rate is None else largest_count(clean, rate)
                found = case_rates(counts > most, cases, drives)
                rows.append(BaselineRow(name, iou, rate, most, found))
    return rows


def pairs_of(triple: Triple, system: SensorSystem) -> tuple[Pair, ...]:
    """Which pairs of sensors are compared: a LiDAR with each camera, cameras with each other."""
    i, j, k = triple
    return ((i, j), (i, k)) if i == 0 and system.has_lidar else ((i, j), (i, k), (j, k))


def _of_states(mismatches: Floats, triple: Triple, system: SensorSystem) -> Floats:
    """All mismatches of a triple in every state, shape (N, states)."""
    columns = system.pairs()
    states = state_vectors(len(system)).astype(int)
    chosen = [(columns.index(pair), *states[:, list(pair)].T) for pair in pairs_of(triple, system)]
    return np.sum([mismatches[:, column, i, k] for column, i, k in chosen], axis=0)


def largest_count(counts: Floats, rate: float) -> int:
    """So many that the share `rate` of the counts, or less, is larger.

    Args:
        counts: Mismatches of clean frames, shape (N,).
        rate: The false alarm rate r, from 0 to below 1.

    Example:
        >>> largest_count(np.array([0, 3, 1, 2]), 0.25)
        2
    """
    return int(np.sort(counts)[len(counts) - 1 - int(rate * len(counts) + 1e-9)])
