"""Are two attacked ones of five sensors named?  A LiDAR and four cameras, up to n - 2 attacked.

The thesis tries algorithm 2 with four sensors, of which one is attacked.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from avsec_gym.experiments.chapter3.identification.detection_rates import RATES
from avsec_gym.experiments.chapter3.identification.evidence_table import evidence_table
from avsec_gym.experiments.chapter3.identification.identification_rates import (
    Concluded,
    algorithm_2,
    fitted_model,
    identification_rates,
    maximum_likelihood,
)
from avsec_gym.experiments.chapter3.identification.state_evidence_cells import StateEvidences, bits
from avsec_gym.experiments.chapter3.recordings import FITTED, JUDGED, fitted_to, moment_cells
from avsec_gym.experiments.experiment import Cell, Configuration
from avsec_gym.experiments.results import Results
from avsec_gym.sensor_system import LIDAR, SensorSystem
from avsec_gym.validation.evidence.evidence import EVIDENCE_FORMAT
from avsec_gym.validation.state_posterior import state_vectors

FIVE = SensorSystem((LIDAR, 1, 3, 0, 2))
"""All sensors of the rig, cameras from right to left."""
FEWEST = 20
"""Moments of each part, below which nothing is summed up."""

_WORK = f"{__name__}:FiveStateEvidences"


class FiveStateEvidences(StateEvidences):
    """`StateEvidences` of five sensors, in all 32 states, under the thesis' attacks alone."""

    system = FIVE
    beyond = ()


def five_cells(configuration: Configuration) -> list[Cell]:
    """A cell for every moment, first those that are fitted on."""
    parts = (FITTED, JUDGED)
    return moment_cells(_WORK, configuration, parts, FIVE, format=EVIDENCE_FORMAT)


def five_summary(results: Results, configuration: Configuration) -> dict[str, Any] | None:
    """What is named of five sensors; None where either part has fewer than `FEWEST` moments.

    Returns:
        ``moments`` of each part, and ``identification``: rows of `identification_rates` with their
        ``method``.
    """
    nobody = bits(state_vectors(len(FIVE))[0])
    counts = {
        part: len({row["scenario"] for row in results.measurements(setting=f"{part} {nobody}")})
        for part in (FITTED, JUDGED)
    }
    if min(counts.values()) < FEWEST:
        return None
    fitted, judged = (evidence_table(results, part, FIVE) for part in (FITTED, JUDGED))
    on = fitted_to(configuration, FIVE)
    methods: dict[str, Callable[[float], Concluded]] = {
        "algorithm 2, error": partial(algorithm_2, fitted, judged, on, criterion="error"),
        "algorithm 2, any": partial(algorithm_2, fitted, judged, on),
        "maximum likelihood": partial(maximum_likelihood, fitted_model(fitted, on), judged),
    }
    rows = [
        {"method": name, **row}
        for name, conclude in methods.items()
        for row in identification_rates(conclude, judged.drives, len(FIVE), RATES)
    ]
    return {"moments": {FITTED: len(fitted), JUDGED: len(judged)}, "identification": rows}
