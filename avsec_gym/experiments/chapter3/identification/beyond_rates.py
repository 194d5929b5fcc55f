"""Detection and identification rates of attacks beyond the thesis' settings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from avsec_gym.experiments.chapter3.identification.detection_rates import exceeded
from avsec_gym.experiments.chapter3.identification.evidence_table import EvidenceTable
from avsec_gym.experiments.chapter3.identification.identification_rates import (
    algorithm_2,
    maximum_likelihood,
)
from avsec_gym.experiments.chapter3.settings import SCENARIOS
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.validation.fitted_on import FittedOn
from avsec_gym.validation.likelihood.maximum_likelihood import LikelihoodModel

RATE = 0.01
"""r."""


@dataclass(frozen=True)
class BeyondRow:
    """How often an attack beyond the thesis' settings is detected, and its sensor alone named.

    Args:
        kind: The kind of attack, one of `BEYOND`.
        sensor: The attacked sensor, 0 for S_0.
        detected: The share that is detected by the first of `SCENARIOS` that holds the sensor.
        detected_by_error: The same by E alone.
        named: The share named by algorithm 2.
        named_likeliest: The share named by maximum likelihood.
    """

    kind: str
    sensor: int
    detected: Share
    detected_by_error: Share
    named: Share
    named_likeliest: Share


def beyond_rates(
    fitted: EvidenceTable, judged: Mapping[str, EvidenceTable], on: FittedOn, model: LikelihoodModel
) -> list[BeyondRow]:
    """How often each kind of attack on each sensor is detected, and this sensor alone named.

    Args:
        fitted: The frames whose clean states give the thresholds.
        judged: The frames by kind (`BEYOND`) in the states with one attacked sensor (`alone`).
        on: The sensors and the depth that the thresholds hold for.
        model: The likelihood model that was fitted on the same frames.
    """
    rows = []
    sensors = len(on.system)
    for kind, table in judged.items():
        alarms = exceeded(fitted, table, on, RATE)
        by_error = exceeded(fitted, table, on, RATE, "error")
        ways = (algorithm_2(fitted, table, on, RATE), maximum_likelihood(model, table, RATE))
        exact = [(found.sensors == np.eye(sensors, dtype=bool)).all(axis=2) for found in ways]
        for sensor in range(sensors):
            triple = next(triple for triple in SCENARIOS.values() if sensor in triple)
            column = on.system.triples.index(triple)
            shares = {
                "detected": alarms[:, sensor, column],
                "detected_by_error": by_error[:, sensor, column],
                "named": exact[0][:, sensor],
                "named_likeliest": exact[1][:, sensor],
            }
            rates = {name: share_of(hits, table.drives) for name, hits in shares.items()}
            rows.append(BeyondRow(kind, sensor, **rates))
    return rows
