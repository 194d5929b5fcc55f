"""What a run of chapter 3 comes to: detection, identification, honesty, as JSON."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from avsec_gym.experiments.chapter3.detection_rates import (
    RATES,
    SCENARIOS,
    attack_cases_of,
    detection_rates,
)
from avsec_gym.experiments.chapter3.evidence_table import EvidenceTable, evidence_table
from avsec_gym.experiments.chapter3.identification_rates import (
    Found,
    algorithm_2,
    fitted_model,
    honesty,
    identification_rates,
    maximum_likelihood,
)
from avsec_gym.experiments.chapter3.recordings import (
    FITTED,
    JUDGED,
    OPTIONS,
    SYSTEM,
    recordings_of,
)
from avsec_gym.experiments.experiment import Configuration
from avsec_gym.experiments.results import Results
from avsec_gym.validation.disparity_error import MEASURES
from avsec_gym.validation.fitted_on import FittedOn, fitted_on
from avsec_gym.validation.pair_depth import PairDepth
from avsec_gym.validation.thresholds import Criterion

CRITERIA: tuple[Criterion, ...] = ("error", "any")
"""E alone, as in the thesis; and all shares that a triple gives."""
FEWEST = 20
"""Moments of each part, below which nothing is summed up."""

_BINS = 50


def validation_summary(results: Results, configuration: Configuration) -> dict[str, Any] | None:
    """All figures of a run; None where either part has fewer than `FEWEST` moments.

    Args:
        results: Of `avsec run identification`.
        configuration: Of the run.

    Raises:
        DataError: The recordings are not where they were.
    """
    counts = [
        len({row["scenario"] for row in results.measurements(setting=f"{part} 0000")})
        for part in (FITTED, JUDGED)
    ]
    if min(counts) < FEWEST:
        return None
    fitted, judged = (evidence_table(results, part, SYSTEM) for part in (FITTED, JUDGED))
    on = fitted_to(configuration)
    model = fitted_model(fitted, on)
    methods: dict[str, Callable[[float], Found]] = {
        f"algorithm 2, {criterion}": partial(algorithm_2, fitted, judged, on, criterion=criterion)
        for criterion in CRITERIA
    }
    methods["maximum likelihood"] = partial(maximum_likelihood, model, judged)
    return {
        "moments": {FITTED: len(fitted), JUDGED: len(judged)},
        "depth": dict(on.depth),
        "detection": [
            row
            for criterion in CRITERIA
            for row in detection_rates(fitted, judged, on, criterion, RATES)
        ],
        "identification": [
            {"method": name, **row}
            for name, conclude in methods.items()
            for row in identification_rates(conclude, len(SYSTEM), RATES)
        ],
        "honesty": honesty(model, judged),
        "distributions": distributions(judged),
    }


def fitted_to(configuration: Configuration) -> FittedOn:
    """What thresholds and likelihoods of a run hold for."""
    options = {**OPTIONS, **configuration.options}
    recordings = recordings_of(configuration, FITTED)
    frame = recordings.moments[0].frame()
    data = {"scenarios": configuration.scenarios, "seed": configuration.seed}
    return fitted_on(SYSTEM, PairDepth(options["depth"]), frame.calibration, data)


def distributions(judged: EvidenceTable) -> list[dict[str, Any]]:
    """How often each share is how large, without attack and in all seven cases together.

    Returns:
        For each scenario and share: ``clean`` and ``attacked``, the share of moments in each of
        fifty equal bins from 0 to ``largest``.
    """
    rows = []
    for scenario, triple in SCENARIOS.items():
        column = judged.system.triples.index(triple)
        cases = list(attack_cases_of(triple, len(judged.system)))
        for number, measure in enumerate(MEASURES):
            clean = judged.measures[:, 0, column, number]
            attacked = judged.measures[:, cases, column, number].ravel()
            largest = max(float(attacked.max()), float(clean.max()), 1e-6)
            edges = np.linspace(0.0, largest, _BINS + 1)
            rows.append(
                {
                    "scenario": scenario,
                    "measure": measure,
                    "largest": largest,
                    "clean": _shares(clean, edges),
                    "attacked": _shares(attacked, edges),
                }
            )
    return rows


def _shares(values: Any, edges: Any) -> list[float]:
    counts, _ = np.histogram(values, edges)
    return [float(share) for share in counts / len(values)]
