"""How large disparity errors are, clean and attacked (figures 3.5, 3.7 and 3.9 of the thesis)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from avsec_gym.experiments.chapter3.identification.detection_rates import attack_cases_of, case_name
from avsec_gym.experiments.chapter3.identification.evidence_table import EvidenceTable
from avsec_gym.experiments.chapter3.settings import SCENARIOS
from avsec_gym.experiments.chapter3.thesis import ERROR_BOUNDS
from avsec_gym.geometry import Floats
from avsec_gym.metrics.clustered_shares import share_of
from avsec_gym.sensor_system import Triple
from avsec_gym.validation.evidence.disparity_error import MEASURES

_BINS = 40


def case_distributions(judged: EvidenceTable) -> list[dict[str, Any]]:
    """E of each system of three sensors, without attack and in each of the seven cases.

    Returns:
        Rows with ``scenario``; ``largest``, up to where there are forty equal bins from 0;
        ``clean``, and by name ``cases``: the share of frames in each bin; ``bounds``, see
        `ERROR_BOUNDS`: with ``clean_below`` the first, and ``attacked_above`` the second.
    """
    rows = []
    for scenario, triple in SCENARIOS.items():
        cases = {0: (), **attack_cases_of(triple, len(judged.system))}
        largest, shares = _histograms(judged, triple, cases)
        clean = shares.pop("")
        attacked = [state for state in cases if state]
        beside = _beside_bounds(judged, triple, [0], attacked)
        rows.append(
            {"scenario": scenario, "largest": largest, "clean": clean, "cases": shares, **beside}
        )
    return rows


def reference_distributions(judged: EvidenceTable) -> list[dict[str, Any]]:
    """E of every triple of the reference, without attack and with each sensor attacked alone.

    Returns:
        Rows with ``triple``, ``largest``, and by name ``cases``, the clean one's ``""`` first;
        where the thesis has bounds for this figure, also the bounds as of `case_distributions`.
    """
    sensors = len(judged.system)
    cases = {0: (), **{1 << sensor: (sensor,) for sensor in range(sensors)}}
    rows = []
    for triple in judged.system.triples:
        if triple[2] == sensors - 1:
            largest, shares = _histograms(judged, triple, cases)
            row: dict[str, Any] = {"triple": list(triple), "largest": largest, "cases": shares}
            if triple in ERROR_BOUNDS and triple not in SCENARIOS.values():
                touched = [state for state, case in cases.items() if {*case} & {*triple}]
                others = [state for state in cases if state not in touched]
                row |= _beside_bounds(judged, triple, others, touched)
            rows.append(row)
    return rows


def _beside_bounds(
    judged: EvidenceTable,
    triple: Triple,
    clean: Sequence[int],
    attacked: Sequence[int],
) -> dict[str, Any]:
    errors, bounds = _errors(judged, triple), ERROR_BOUNDS[triple]
    below = errors[:, list(clean)] < bounds.clean_below
    above = errors[:, list(attacked)] > bounds.attacked_above
    return {
        "bounds": [bounds.clean_below, bounds.attacked_above],
        "clean_below": share_of(below, judged.drives),
        "attacked_above": share_of(above, judged.drives),
    }


def _histograms(
    judged: EvidenceTable, triple: Triple, cases: Mapping[int, tuple[int, ...]]
) -> tuple[float, dict[str, list[float]]]:
    """The largest error, and by the attacked sensors (``""``: none) the share in each bin."""
    errors = _errors(judged, triple)
    largest = max(float(errors[:, list(cases)].max()), 1e-6)
    edges = np.linspace(0.0, largest, _BINS + 1)
    counts = {
        case_name(case): np.histogram(errors[:, state], edges)[0] for state, case in cases.items()
    }
    return largest, {case: (count / len(judged)).tolist() for case, count in counts.items()}


def _errors(judged: EvidenceTable, triple: Triple) -> Floats:
    """E of one triple, shape (N, states)."""
    return judged.measures[:, :, judged.system.triples.index(triple), MEASURES.index("error")]
