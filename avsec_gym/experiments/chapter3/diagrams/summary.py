"""The rates of the diagrams: what is detected, named and believed over the open parameters."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter3.diagrams.evidence_cells import (
    ATTACKED_CAMERAS,
    POINTS,
    benign_name,
    clean_name,
    fitted_kind,
    judged_kind,
    only,
)
from avsec_gym.experiments.chapter3.diagrams.object_rates import ObjectRates, object_rates
from avsec_gym.experiments.chapter3.diagrams.settings import DiagramSettings
from avsec_gym.experiments.chapter3.diagrams.variant import Variant, is_of_lidar
from avsec_gym.experiments.chapter3.identification.detection_rates import exceeded
from avsec_gym.experiments.chapter3.identification.evidence_table import (
    EvidenceTable,
    evidence_table,
)
from avsec_gym.experiments.chapter3.identification.identification_rates import (
    CRITERIA,
    algorithm_2,
    fitted_model,
    maximum_likelihood,
)
from avsec_gym.experiments.chapter3.recordings import SYSTEM
from avsec_gym.experiments.chapter3.settings import SCENARIOS
from avsec_gym.experiments.json_rows import FLAT
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.runs.experiment import Configuration
from avsec_gym.runs.results import Results
from avsec_gym.validation.benign_changes import BENIGN_CHANGES
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.fitted_on import FittedOn
from avsec_gym.validation.likelihood.maximum_likelihood import LikelihoodModel
from avsec_gym.validation.state_posterior import States, state_vectors

RATE = 0.01
"""The designated false alarm rate r."""
LIKELIHOOD = "likelihood"
RULES = (*CRITERIA, LIKELIHOOD)
"""E alone and all four shares, by thresholds; and maximum likelihood."""
FEWEST = 20
"""Frames of each part, below which nothing is summed up."""
NO_CHANGE = "none"
SCENARIO = "LiDAR and two cameras"
"""Three sensors that detect by thresholds; likelihood detects by four, and all rules name four."""


@dataclass(frozen=True)
class DiagramRow:
    """How often an attack is detected, and exactly its sensor named.

    Args:
        matcher: How disparities are found.
        variant: The attack.
        points: Mean number of bogus points; None of a light.
        detected: The share that is detected, by `RULES`.
        named: The share of which exactly the attacked sensor is named, no other, by `RULES`.
    """

    matcher: str
    variant: Variant = field(metadata=FLAT)
    points: float | None
    detected: Mapping[str, Share]
    named: Mapping[str, Share]


@dataclass(frozen=True)
class BenignRow:
    """How often a change that is no attack raises an alarm.

    Args:
        matcher: How disparities are found.
        change: One of `BENIGN_CHANGES`, of one camera; or `NO_CHANGE`.
        alarms: The share that raises an alarm, by `RULES`.
        named: The share of frames in which some sensor is named as attacked, by `RULES`.
    """

    matcher: str
    change: str
    alarms: Mapping[str, Share]
    named: Mapping[str, Share]


@dataclass(frozen=True)
class DiagramsSummary:
    """All diagrams of a run.

    Args:
        rate: The designated false alarm rate r.
        frames: Frames judged by each matcher.
        attacks: A row for every matcher and attack.
        benign: A row for every matcher and change.
        objects: What detectors see; None: nothing was shown to them.
    """

    rate: float
    frames: Mapping[str, int]
    attacks: Sequence[DiagramRow]
    benign: Sequence[BenignRow]
    objects: ObjectRates | None


@dataclass(frozen=True, eq=False)
class Fitted:
    """What one matcher's evidence in one scan is judged by.

    Args:
        table: Evidence of the frames to fit on.
        on: The sensors, and the depth.
        model: p(evidence | **s**) of the same frames.
    """

    table: EvidenceTable
    on: FittedOn
    model: LikelihoodModel


@dataclass(frozen=True, eq=False)
class Judged:
    """What rules conclude of frames in one state each.

    Args:
        frames: Ids of N frames.
        drives: The drives of the frames.
        alarms: Whether there is an alarm, by `RULES`, shape (N,).
        exact: Whether exactly the attacked sensors are named, by `RULES`, shape (N,).
        some: Whether any sensor is named, by `RULES`, shape (N,).
    """

    frames: Sequence[str]
    drives: Sequence[str]
    alarms: Mapping[str, NDArray[np.bool_]]
    exact: Mapping[str, NDArray[np.bool_]]
    some: Mapping[str, NDArray[np.bool_]]


def diagrams_summary(results: Results, configuration: Configuration) -> DiagramsSummary | None:
    """All diagrams of a run; None where no matcher has `FEWEST` frames of each part."""
    settings = DiagramSettings.of(configuration)
    scans, variants = settings.scans, settings.variants()
    attacks: list[DiagramRow] = []
    benign: list[BenignRow] = []
    frames = {}
    for matcher, depth in settings.depths().items():
        clean = {scan: _table(results, matcher, clean_name(scan), 0) for scan in scans}
        fitted = {scan: _fitted(results, matcher, depth, scan) for scan in scans}
        known = {scan: found for scan, found in fitted.items() if found is not None}
        least = min(len(table) if table else 0 for table in clean.values())
        if len(known) < len(scans) or least < FEWEST:
            continue
        frames[matcher] = least
        for variant in variants:
            positions = (0,) if is_of_lidar(variant) else ATTACKED_CAMERAS
            found = _judge(results, matcher, variant.name, known[variant.scan], positions)
            if found is not None:
                points = _points(results, judged_kind(matcher, variant.name))
                row = DiagramRow(
                    matcher, variant, points, _shares(found, found.alarms),
                    _shares(found, found.exact),
                )  # fmt: skip
                attacks.append(row)
        benign += _benign(results, matcher, scans[0], known[scans[0]])
    objects = object_rates(results, configuration, RATE, FEWEST)
    if not attacks and objects is None:
        return None
    return DiagramsSummary(RATE, frames, attacks, benign, objects)


def _benign(results: Results, matcher: str, scan: int, fitted: Fitted) -> list[BenignRow]:
    """False alarms without a change, and with each."""
    whats = {NO_CHANGE: (clean_name(scan), (None,))} | {
        change: (benign_name(change), ATTACKED_CAMERAS) for change in BENIGN_CHANGES
    }
    rows = []
    for change, (what, positions) in whats.items():
        found = _judge(results, matcher, what, fitted, positions)
        if found is not None:
            alarms, named = _shares(found, found.alarms), _shares(found, found.some)
            rows.append(BenignRow(matcher, change, alarms, named))
    return rows


def _shares(found: Judged, hits: Mapping[str, NDArray[np.bool_]]) -> dict[str, Share]:
    return {rule: share_of(hits[rule], found.drives) for rule in RULES}


def _judge(
    results: Results,
    matcher: str,
    what: str,
    fitted: Fitted,
    positions: Sequence[int | None],
) -> Judged | None:
    """Conclude of all frames, whichever sensor is attacked in each; None: there is none.

    Args:
        results: The results of a run.
        matcher: How disparities are found.
        what: What the evidence is filed under, with the matcher.
        fitted: What it is judged by.
        positions: Positions of the sensors that may be attacked; None: none is.
    """
    parts = []
    for position in positions:
        states = _state(position)
        table = _states_table(results, judged_kind(matcher, what), states)
        if table is not None:
            parts.append(judged_frames(table, fitted, states))
    if not parts:
        return None
    return Judged(
        [id for part in parts for id in part.frames],
        [drive for part in parts for drive in part.drives],
        *(
            {rule: np.concatenate([getattr(part, name)[rule] for part in parts]) for rule in RULES}
            for name in ("alarms", "exact", "some")
        ),
    )


def judged_frames(table: EvidenceTable, fitted: Fitted, states: States) -> Judged:
    """What each rule concludes of frames that are all in one state.

    Args:
        table: The evidence of the frames.
        fitted: What it is judged by.
        states: The state, shape (1, n + 1).
    """
    column = SYSTEM.triples.index(SCENARIOS[SCENARIO])
    alarms, named = {}, {}
    for criterion in CRITERIA:
        beyond = exceeded(fitted.table, table, fitted.on, RATE, criterion)
        alarms[str(criterion)] = beyond[:, 0, column]
        found = algorithm_2(fitted.table, table, fitted.on, RATE, criterion)
        named[str(criterion)] = found.sensors[:, 0]
    likeliest = maximum_likelihood(fitted.model, table, RATE)
    alarms[LIKELIHOOD], named[LIKELIHOOD] = likeliest.alarms[:, 0], likeliest.sensors[:, 0]
    return Judged(
        table.frames,
        table.drives,
        alarms,
        {rule: np.asarray((sensors == states[0]).all(axis=1)) for rule, sensors in named.items()},
        {rule: np.asarray(sensors.any(axis=1)) for rule, sensors in named.items()},
    )


def fitted_to_table(table: EvidenceTable, depth: PairDepth) -> Fitted:
    """Fit thresholds and likelihood; they are not kept, so that the scales do not matter.

    Args:
        table: The evidence of frames to fit on, in all states.
        depth: How disparities are found.
    """
    on = FittedOn(SYSTEM, depth.settings, (), {})
    return Fitted(table, on, fitted_model(table, on))


def _fitted(results: Results, matcher: str, depth: PairDepth, scan: int) -> Fitted | None:
    table = _states_table(results, fitted_kind(matcher, scan), state_vectors(len(SYSTEM)))
    if table is None or len(table) < FEWEST:
        return None
    return fitted_to_table(table, depth)


def _table(results: Results, matcher: str, what: str, position: int) -> EvidenceTable | None:
    return _states_table(results, judged_kind(matcher, what), _state(None))


def _state(position: int | None) -> States:
    return np.asarray(state_vectors(len(SYSTEM))[:1]) if position is None else only(position)


def _states_table(results: Results, kind: str, states: States) -> EvidenceTable | None:
    """None: no frame is there, or none is whole."""
    try:
        return evidence_table(results, kind, SYSTEM, states)
    except ConfigurationError:
        return None


def _points(results: Results, kind: str) -> float | None:
    """Mean number of bogus points; None: it is a light."""
    counts = [row.value for row in results.measurements(setting=kind, name=POINTS)]
    return float(np.mean(counts)) if counts else None


RowOf = Callable[[DiagramRow], Mapping[str, Share]]
"""What of a row a diagram shows: `DiagramRow.detected` or `DiagramRow.named`."""
