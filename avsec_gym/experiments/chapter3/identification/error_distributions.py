"""How large disparity errors are, clean and attacked (figures 3.5, 3.7 and 3.9 of the thesis)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from avsec_gym.experiments.chapter3.identification.detection_rates import attack_cases_of, case_name
from avsec_gym.experiments.chapter3.identification.evidence_table import EvidenceTable
from avsec_gym.experiments.chapter3.settings import SCENARIOS
from avsec_gym.experiments.chapter3.thesis import ERROR_BOUNDS
from avsec_gym.experiments.json_rows import FLAT
from avsec_gym.geometry import Floats
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.sensor_system import Triple
from avsec_gym.validation.evidence.disparity_error import MEASURES

_BINS = 40


@dataclass(frozen=True)
class BesideBounds:
    """The side of the thesis' bounds that E lies on.

    Args:
        bounds: The bound of clean frames and that of attacked ones, see `ERROR_BOUNDS`.
        clean_below: The clean frames below the first.
        attacked_above: The attacked frames above the second.
    """

    bounds: Sequence[float]
    clean_below: Share
    attacked_above: Share


@dataclass(frozen=True)
class CaseDistribution:
    """E of a system of three sensors.

    Args:
        scenario: The system, one of `SCENARIOS`.
        largest: The largest error, up to where there are forty equal bins from 0.
        clean: The share of clean frames in each bin.
        cases: The same of attacked ones, by the attacked sensors.
        beside: The side of the thesis' bounds on which E lies.
    """

    scenario: str
    largest: float
    clean: Sequence[float]
    cases: Mapping[str, Sequence[float]]
    beside: BesideBounds = field(metadata=FLAT)


@dataclass(frozen=True)
class ReferenceDistribution:
    """E of a triple that the reference is in.

    Args:
        triple: Positions of its sensors.
        largest: The largest error, see `CaseDistribution`.
        cases: The share of frames in each bin, by the attacked sensor; ``""``, the first, is clean.
        beside: Where the thesis has bounds for this figure.
    """

    triple: Sequence[int]
    largest: float
    cases: Mapping[str, Sequence[float]]
    beside: BesideBounds | None = field(metadata=FLAT)


def case_distributions(judged: EvidenceTable) -> list[CaseDistribution]:
    """E of each system of three sensors, without attack and in each of the seven cases."""
    rows = []
    for scenario, triple in SCENARIOS.items():
        cases = {0: (), **attack_cases_of(triple, len(judged.system))}
        largest, shares = _histograms(judged, triple, cases)
        clean = shares.pop("")
        attacked = [state for state in cases if state]
        beside = _beside_bounds(judged, triple, [0], attacked)
        rows.append(CaseDistribution(scenario, largest, clean, shares, beside))
    return rows


def reference_distributions(judged: EvidenceTable) -> list[ReferenceDistribution]:
    """E of every triple of the reference, without attack and with each sensor attacked alone."""
    sensors = len(judged.system)
    cases = {0: (), **{1 << sensor: (sensor,) for sensor in range(sensors)}}
    rows = []
    for triple in judged.system.triples:
        if triple[2] == sensors - 1:
            largest, shares = _histograms(judged, triple, cases)
            beside = None
            if triple in ERROR_BOUNDS and triple not in SCENARIOS.values():
                touched = [state for state, case in cases.items() if {*case} & {*triple}]
                others = [state for state in cases if state not in touched]
                beside = _beside_bounds(judged, triple, others, touched)
            rows.append(ReferenceDistribution(list(triple), largest, shares, beside))
    return rows


def _beside_bounds(
    judged: EvidenceTable,
    triple: Triple,
    clean: Sequence[int],
    attacked: Sequence[int],
) -> BesideBounds:
    errors, bounds = _errors(judged, triple), ERROR_BOUNDS[triple]
    below = errors[:, list(clean)] < bounds.clean_below
    above = errors[:, list(attacked)] > bounds.attacked_above
    return BesideBounds(
        [bounds.clean_below, bounds.attacked_above],
        share_of(below, judged.drives),
        share_of(above, judged.drives),
    )


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
