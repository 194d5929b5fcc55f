"""Are two attacked ones of five sensors named?  A LiDAR and four cameras, up to n - 2 attacked.

The thesis tries algorithm 2 with four sensors, of which one is attacked.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from avsec_gym.experiments.chapter3.identification.evidence_table import evidence_table
from avsec_gym.experiments.chapter3.identification.identification_rates import (
    MethodRates,
    fitted_model,
    rates_of_methods,
)
from avsec_gym.experiments.chapter3.identification.state_evidence_cells import StateEvidences, bits
from avsec_gym.experiments.chapter3.recordings import (
    FITTED,
    JUDGED,
    drives_inputs,
    fitted_to,
    frame_cells,
)
from avsec_gym.experiments.chapter3.settings import RATES
from avsec_gym.runs.experiment import Cell, Configuration
from avsec_gym.runs.results import Results
from avsec_gym.sensor_system import LIDAR, SensorSystem
from avsec_gym.validation.evidence.evidence import EVIDENCE_FORMAT
from avsec_gym.validation.state_posterior import state_vectors

FIVE = SensorSystem((LIDAR, 1, 3, 0, 2))
"""All sensors of the rig, cameras from right to left."""
FEWEST = 20
"""Frames of each part, below which nothing is summed up."""

_WORK = f"{__name__}:FiveStateEvidences"


class FiveStateEvidences(StateEvidences):
    """`StateEvidences` of five sensors, in all 32 states, under the thesis' attacks alone."""

    system = FIVE
    beyond = ()


def five_cells(configuration: Configuration) -> list[Cell]:
    """A cell for every frame, first those that are fitted on."""
    parts = (FITTED, JUDGED)
    return frame_cells(_WORK, configuration, parts, FIVE, format=EVIDENCE_FORMAT)


def five_inputs(configuration: Configuration) -> dict[str, Path]:
    """The manifests of procedural drives."""
    return drives_inputs(configuration, (FITTED, JUDGED), FIVE)


@dataclass(frozen=True)
class FiveSummary:
    """What is named of five sensors.

    Args:
        frames: The number of frames of each part.
        identification: The rates of `rates_of_methods`.
    """

    frames: Mapping[str, int]
    identification: Sequence[MethodRates]


def five_summary(results: Results, configuration: Configuration) -> FiveSummary | None:
    """What is named of five sensors; None where either part has fewer than `FEWEST` frames."""
    clean = bits(state_vectors(len(FIVE))[0])
    counts = {
        part: len({row.scenario for row in results.measurements(setting=f"{part} {clean}")})
        for part in (FITTED, JUDGED)
    }
    if min(counts.values()) < FEWEST:
        return None
    fitted, judged = (evidence_table(results, part, FIVE) for part in (FITTED, JUDGED))
    on = fitted_to(configuration, FIVE)
    rows = rates_of_methods(fitted, judged, on, fitted_model(fitted, on), RATES)
    return FiveSummary({FITTED: len(fitted), JUDGED: len(judged)}, rows)
