"""How often exactly the attacked sensors are named: by the car alone, and with the others."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from avsec_gym.experiments.chapter4.joined.cells import (
    ALARM,
    CASES,
    FAMILIAR,
    OWN_STATE,
    RECOVERED_STATE,
    STATUS,
    STATUSES,
)
from avsec_gym.metrics.clustered_shares import Share
from avsec_gym.runs.results import Results
from avsec_gym.sensor_system import LIDAR, Sensor
from avsec_gym.validation.connected.joined_identification import (
    StatusLikelihood,
    joined_posterior,
)
from avsec_gym.validation.detection import LIDAR_AND_TWO_CAMERAS
from avsec_gym.validation.state_posterior import (
    Decoding,
    SensorStatus,
    StatePosterior,
    state_vectors,
)

FrameMeasurements = Mapping[str, float]
"""The measurements of a frame by their names."""


@dataclass(frozen=True)
class JoinedRow:
    """What is named in the frames of a case.

    Args:
        attacked: The attacked sensors, in words.
        alone: Frames in which the car itself names these and no others; without an attack, none.
        joined: The same with what connected vehicles report.
        lidar_named: Frames in which connected vehicles name the LiDAR.
    """

    attacked: str
    alone: Share
    joined: Share
    lidar_named: Share


def joined_rows(results: Results) -> list[JoinedRow]:
    """A row for each case of a run; a place is one frame of each.

    What a report of connected vehicles is worth is counted over all other places.
    """
    frames = {case: _frames(results, case) for case in CASES}
    return [
        _row(case, sensors, frames[case], frames) for case, sensors in CASES.items() if frames[case]
    ]


def _row(
    case: str,
    sensors: Sequence[Sensor],
    own: Mapping[str, FrameMeasurements],
    frames: Mapping[str, Mapping[str, FrameMeasurements]],
) -> JoinedRow:
    alone, joined, named = [], [], []
    expected = frozenset(sensors)
    for place, values in own.items():
        likelihood = _likelihood_without(place, frames)
        status = STATUSES[int(values[STATUS])]
        posterior = _posterior(values, OWN_STATE)
        recovered = None
        if status == SensorStatus.ATTACKED:
            recovered = _posterior(values, RECOVERED_STATE)
        both = joined_posterior(posterior, likelihood.ratio(status), recovered)
        of_car = _named(
            posterior, values[f"{OWN_STATE} {ALARM}"], values[f"{OWN_STATE} {FAMILIAR}"]
        )
        alone.append(of_car == expected)
        joined.append(_named(both, values[ALARM], values[FAMILIAR]) == expected)
        named.append(status == SensorStatus.ATTACKED)
    count = len(own)
    return JoinedRow(
        case.removeprefix("joined "),
        *(Share.of_counts(sum(hits), count) for hits in (alone, joined, named)),
    )


def _named(posterior: StatePosterior, alarm: float, familiar: float) -> frozenset[Sensor]:
    decoding = Decoding(posterior, np.array([alarm > 0]), np.array([familiar > 0]))
    statuses = zip(LIDAR_AND_TWO_CAMERAS.sensors, decoding.statuses()[0], strict=True)
    return frozenset(sensor for sensor, status in statuses if status == SensorStatus.ATTACKED)


def _posterior(values: FrameMeasurements, name: str) -> StatePosterior:
    count = len(state_vectors(len(LIDAR_AND_TWO_CAMERAS)))
    return StatePosterior(np.array([[values[f"{name} {index}"] for index in range(count)]]))


def _likelihood_without(
    place: str, frames: Mapping[str, Mapping[str, FrameMeasurements]]
) -> StatusLikelihood:
    """What statuses are worth by all places but one."""
    counts: dict[bool, Counter[str]] = {True: Counter(), False: Counter()}
    for case, sensors in CASES.items():
        for other, values in frames[case].items():
            if other != place:
                counts[LIDAR in sensors][STATUSES[int(values[STATUS])]] += 1
    return StatusLikelihood(counts[True], counts[False])


def _frames(results: Results, case: str) -> dict[str, dict[str, float]]:
    """The measurements of a case by place."""
    found: dict[str, dict[str, float]] = {}
    for row in results.measurements(setting=case):
        found.setdefault(row.scenario, {})[row.name] = row.value
    return found
