"""How large disparity errors are, clean and attacked (figures 3.5, 3.7 and 3.9 of the thesis)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from avsec_gym.experiments.chapter3.identification.detection_rates import (
    SCENARIOS,
    attack_cases_of,
    case_name,
)
from avsec_gym.experiments.chapter3.identification.evidence_table import EvidenceTable
from avsec_gym.sensor_system import Triple
from avsec_gym.validation.evidence.disparity_error import MEASURES

_BINS = 40


def case_distributions(judged: EvidenceTable) -> list[dict[str, Any]]:
    """E of each system of three sensors, without attack and in each of the seven cases.

    Returns:
        Rows with ``scenario``; ``largest``, up to where there are forty equal bins from 0;
        ``clean``, and by name ``cases``: the share of moments in each bin.
    """
    rows = []
    for scenario, triple in SCENARIOS.items():
        cases = {0: (), **attack_cases_of(triple, len(judged.system))}
        largest, shares = _histograms(judged, triple, cases)
        clean = shares.pop("")
        rows.append({"scenario": scenario, "largest": largest, "clean": clean, "cases": shares})
    return rows


def reference_distributions(judged: EvidenceTable) -> list[dict[str, Any]]:
    """E of every triple of the reference, without attack and with each sensor attacked alone.

    Returns:
        Rows with ``triple``, ``largest``, and by name ``cases``, the clean one's ``""`` first.
    """
    sensors = len(judged.system)
    cases = {0: (), **{1 << one: (one,) for one in range(sensors)}}
    rows = []
    for triple in judged.system.triples:
        if triple[2] == sensors - 1:
            largest, shares = _histograms(judged, triple, cases)
            rows.append({"triple": list(triple), "largest": largest, "cases": shares})
    return rows


def _histograms(
    judged: EvidenceTable, triple: Triple, cases: Mapping[int, tuple[int, ...]]
) -> tuple[float, dict[str, list[float]]]:
    """The largest error, and by the attacked sensors (``""``: none) the share in each bin."""
    errors = judged.measures[:, :, judged.system.triples.index(triple), MEASURES.index("error")]
    largest = max(float(errors[:, list(cases)].max()), 1e-6)
    edges = np.linspace(0.0, largest, _BINS + 1)
    counts = {
        case_name(case): np.histogram(errors[:, state], edges)[0] for state, case in cases.items()
    }
    return largest, {case: (count / len(judged)).tolist() for case, count in counts.items()}
