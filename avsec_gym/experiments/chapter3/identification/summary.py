"""The results of a run of chapter 3: detection, identification, calibration."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from avsec_gym.experiments.chapter3.attacks import BEYOND
from avsec_gym.experiments.chapter3.identification.adaptive_rates import (
    AdaptiveAttackRates,
    adaptive_rates,
)
from avsec_gym.experiments.chapter3.identification.beyond_rates import BeyondRow, beyond_rates
from avsec_gym.experiments.chapter3.identification.calibration import (
    LikelihoodCalibration,
    calibration,
)
from avsec_gym.experiments.chapter3.identification.detection_rates import (
    DetectionRateRow,
    detection_rates,
)
from avsec_gym.experiments.chapter3.identification.error_distributions import (
    CaseDistribution,
    ReferenceDistribution,
    case_distributions,
    reference_distributions,
)
from avsec_gym.experiments.chapter3.identification.evidence_table import (
    EvidenceTable,
    evidence_table,
)
from avsec_gym.experiments.chapter3.identification.identification_rates import (
    CRITERIA,
    IdentificationRates,
    MethodRates,
    fitted_model,
    identification_rates,
    maximum_likelihood,
    rates_of_methods,
)
from avsec_gym.experiments.chapter3.identification.state_evidence_cells import alone
from avsec_gym.experiments.chapter3.recordings import (
    FITTED,
    JUDGED,
    SYSTEM,
    fitted_to,
    recordings_of,
)
from avsec_gym.experiments.chapter3.settings import CURVE_RATES
from avsec_gym.runs.experiment import Configuration
from avsec_gym.runs.results import Results
from avsec_gym.validation.fitted_on import FittedOn
from avsec_gym.validation.likelihood.maximum_likelihood import LikelihoodModel
from avsec_gym.validation.state_posterior import attack_prior, state_vectors
from avsec_gym.validation.thresholds import Criterion

ALONE: tuple[Criterion, ...] = ("hole_share", "densest", "brightness")
"""The other shares, each of which is judged by itself, at r = 1 %."""
FEWEST = 20
"""Frames of each part, below which nothing is summed up."""


@dataclass(frozen=True)
class Unseen:
    """Both rates at r = 1 % without the frames that were looked at while the method was made.

    Args:
        looked_at: How many of the judged frames were.
        frames: How many were not.
        detection: The detection rates of these.
        identification: The identification rates of these.
    """

    looked_at: int
    frames: int
    detection: Sequence[DetectionRateRow]
    identification: Sequence[MethodRates]


@dataclass(frozen=True)
class ValidationSummary:
    """All figures of a run on detection and identification.

    Args:
        frames: The number of frames of each part.
        drives: The number of drives of each part.
        depth: The settings of the depth estimator.
        detection: The detection rates, by system, criterion and r.
        identification: The identification rates, by method and r.
        independent: The rates of maximum likelihood by a prior of independent attacks.
        unseen: The rates without the frames that were looked at; None: there are none.
        calibration: How often statuses and probabilities are right.
        beyond: The rates of attacks beyond the thesis' settings.
        adaptive_attacks: The rates of adaptive attacks.
        case_distributions: E of the two systems of three sensors.
        reference_distributions: E of the triples that the reference is in.
    """

    frames: Mapping[str, int]
    drives: Mapping[str, int]
    depth: Mapping[str, Any]
    detection: Sequence[DetectionRateRow]
    identification: Sequence[MethodRates]
    independent: Sequence[IdentificationRates]
    unseen: Unseen | None
    calibration: LikelihoodCalibration
    beyond: Sequence[BeyondRow]
    adaptive_attacks: Sequence[AdaptiveAttackRates]
    case_distributions: Sequence[CaseDistribution]
    reference_distributions: Sequence[ReferenceDistribution]


def validation_summary(
    results: Results, configuration: Configuration, looked_at: int = 0
) -> ValidationSummary | None:
    """All figures of a run; None where either part has fewer than `FEWEST` frames.

    Args:
        results: The results of `avsec run identification`.
        configuration: The configuration of the run.
        looked_at: How many of the judged frames, the first ones, were looked at while the method
            was made; `Unseen` leaves them out.

    Raises:
        DataError: The recordings are not where they were.
    """
    counts = [
        len({row.scenario for row in results.measurements(setting=f"{part} 0000")})
        for part in (FITTED, JUDGED)
    ]
    if min(counts) < FEWEST:
        return None
    fitted, judged = (evidence_table(results, part, SYSTEM) for part in (FITTED, JUDGED))
    on = fitted_to(configuration)
    model = fitted_model(fitted, on)
    one = alone(state_vectors(len(SYSTEM)))
    beyond = {kind: evidence_table(results, kind, SYSTEM, one) for kind in BEYOND}
    return ValidationSummary(
        frames={FITTED: len(fitted), JUDGED: len(judged)},
        drives={FITTED: len(set(fitted.drives)), JUDGED: len(set(judged.drives))},
        depth=dict(on.depth),
        detection=[
            row
            for criterion in (*CRITERIA, *ALONE)
            for row in detection_rates(
                fitted, judged, on, criterion, CURVE_RATES if criterion in CRITERIA else (0.01,)
            )
        ],
        identification=rates_of_methods(fitted, judged, on, model, CURVE_RATES),
        independent=identification_rates(
            partial(maximum_likelihood, model, judged, prior=attack_prior(len(SYSTEM), beyond=1.0)),
            judged.drives,
            len(SYSTEM),
            (0.01,),
        ),
        unseen=_unseen(looked_at, configuration, fitted, judged, on, model),
        calibration=calibration(model, judged),
        beyond=beyond_rates(fitted, beyond, on, model),
        adaptive_attacks=adaptive_rates(results, fitted, on, model),
        case_distributions=case_distributions(judged),
        reference_distributions=reference_distributions(judged),
    )


def _unseen(
    looked_at: int,
    configuration: Configuration,
    fitted: EvidenceTable,
    judged: EvidenceTable,
    on: FittedOn,
    model: LikelihoodModel,
) -> Unseen | None:
    """Both rates at r = 1 % without the frames that were looked at; None: there are none."""
    if not looked_at:
        return None
    seen = {recorded.id for recorded in recordings_of(configuration, JUDGED).frames[:looked_at]}
    others = judged.without(seen)
    if not len(others):
        return None
    return Unseen(
        len(judged) - len(others),
        len(others),
        detection_rates(fitted, others, on, rates=(0.01,)),
        rates_of_methods(fitted, others, on, model, (0.01,)),
    )
