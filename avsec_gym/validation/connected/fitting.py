"""Fits what connected vehicles decide by, to instants that are never judged.

Each instant is measured without an attack, with a ghost and with a removal. What is measured can be
kept in a file, so that a fit that was stopped goes on with the next instant.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypedDict

import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import DataError
from avsec_gym.geometry import Floats
from avsec_gym.progress import Progress
from avsec_gym.storage.json_lines import JsonLines
from avsec_gym.validation.connected.attacks.attacked_instant import AttackedInstant, InstantAttack
from avsec_gym.validation.connected.attacks.pasted_object import PastedObject
from avsec_gym.validation.connected.attacks.removed_object import RemovedObject
from avsec_gym.validation.connected.constants import ConnectedConstants
from avsec_gym.validation.connected.fit import ConnectedFit
from avsec_gym.validation.connected.ground_epsilon import ground_epsilon
from avsec_gym.validation.connected.proposals.clusters import ClusterProposer
from avsec_gym.validation.connected.rays.decision import DecisionRule, decide
from avsec_gym.validation.connected.rays.fitting import (
    LabelledCounts,
    ScoreProbability,
    fit_calibration,
    fit_rates,
)
from avsec_gym.validation.connected.rays.rates import RayRates
from avsec_gym.validation.connected.rays.witness import WitnessMargins
from avsec_gym.validation.connected.recordings import RecordedInstant
from avsec_gym.validation.connected.scan_pattern import ScanPattern, scan_pattern
from avsec_gym.validation.connected.validator import ConnectedValidator
from avsec_gym.validation.connected.vehicle import RegionProposer


class MeasuredAttack(TypedDict):
    """What is kept of an attacked instant: the regions that are about what was attacked."""

    kind: str
    victim: int
    counts: list[list[int]]
    """Counts as `_listed` has them."""
    distances: list[float]


class MeasuredInstant(TypedDict):
    """What is kept of an instant."""

    id: str
    vehicles: int
    pattern: list[list[float]]
    """Spacing of the lasers and the lowest of them, for each vehicle whose beams are regular."""
    epsilon: float | None
    """None: the vehicles see no common ground."""
    clean: list[list[int]]
    clean_distances: list[float]
    pairs: list[float]
    attacked: list[MeasuredAttack]


_SEE_THROUGH = (-4.0, -3.0, -2.0, -1.0, 0.0)
_PIECES = 8


@dataclass(frozen=True)
class FittedInstants:
    """What is fitted on.

    Args:
        data: What names the instants in the fit's file; JSON-able.
        proposer: The function that proposes regions.
        attacks: What each instant is attacked by, one after the other.
        margins: How far things may lie apart, for rays.
        seed: The seed of the attacks.
    """

    data: Mapping[str, Any] = field(default_factory=dict)
    proposer: RegionProposer = field(default_factory=ClusterProposer)
    attacks: tuple[InstantAttack, ...] = field(default_factory=lambda: _usual_attacks())
    margins: WitnessMargins = field(default_factory=WitnessMargins)
    seed: int = 0


def _usual_attacks() -> tuple[InstantAttack, ...]:
    return PastedObject(), RemovedObject()


def fit_connected(
    instants: Iterable[RecordedInstant],
    count: int,
    on: FittedInstants,
    *,
    samples: Path | None = None,
    on_progress: Progress | None = None,
) -> ConnectedFit:
    """Measure instants, and fit rates, calibrations and thresholds to what was measured.

    Args:
        instants: Instants without an attack, two or more vehicles each.
        count: Number of them.
        on: What they are, and how they are attacked.
        samples: File of this fit alone that keeps what is measured; None: nothing is kept.
        on_progress: Callback after each instant.

    Raises:
        DataError: Too little can be compared to fit anything; or `samples` is damaged.
    """
    kept = JsonLines(samples, MeasuredInstant)
    for number, instant in enumerate(instants):
        if instant.id not in kept.rows:
            kept.add({"id": instant.id, **_measured(instant, number, on)})
        if on_progress is not None:
            on_progress(number + 1, count)
    return _fitted(list(kept.rows.values()), on)


def _measured(instant: RecordedInstant, number: int, on: FittedInstants) -> dict[str, Any]:
    """Counts and distances of an instant, attack-free and attacked."""
    rays = ConnectedValidator(ConnectedConstants(margins=on.margins), "rays", on.proposer)
    patterns = [scan_pattern(scan.points) for scan in instant.scans]
    try:
        epsilon = ground_epsilon([instant.scans], pieces=_PIECES, seed=on.seed)
    except DataError:  # These vehicles see no common ground.
        epsilon = None
    surfaces = replace(rays, method="surfaces")
    clean = surfaces.validate(instant.scans).distances
    row: dict[str, Any] = {
        "vehicles": len(instant.scans),
        "pattern": [[each.spacing, each.lowest] for each in patterns if each is not None],
        "epsilon": epsilon,
        "clean": _listed(rays.validate(instant.scans).counts),
        "clean_distances": _largest(clean),
        "pairs": np.round(_pairs(clean), 3).tolist(),
        "attacked": [],
    }
    for index, attack in enumerate(on.attacks):
        attacked = attack.attack(instant, (on.seed, number, index))
        if attacked is not None:
            row["attacked"].append(_measured_attack(attacked, rays, surfaces))
    return row


def _measured_attack(
    attacked: AttackedInstant, rays: ConnectedValidator, surfaces: ConnectedValidator
) -> dict[str, Any]:
    """Counts and distances of the regions that are about what was attacked."""
    by_rays, by_surfaces = (
        validator.validate(attacked.instant.scans) for validator in (rays, surfaces)
    )
    assert by_rays.counts is not None
    assert by_surfaces.distances is not None
    return {
        "kind": attacked.kind,
        "victim": attacked.victim,
        "counts": _listed(by_rays.counts[attacked.regions(by_rays.regions)]),
        "distances": _largest(by_surfaces.distances[attacked.regions(by_surfaces.regions)]),
    }


def _fitted(rows: list[dict[str, Any]], on: FittedInstants) -> ConnectedFit:
    clean = [_dense(row["clean"], row["vehicles"]) for row in rows]
    attacked = [
        (_dense(each["counts"], row["vehicles"]), each) for row in rows for each in row["attacked"]
    ]
    if not attacked:
        raise DataError("No instant could be attacked, so that nothing can be fitted.")
    rates = fit_rates(_labelled(clean, attacked))
    see_through, calibration = _fitted_scores(clean, [counts for counts, _ in attacked], rates)
    rule = DecisionRule(see_through=see_through)
    highest = [float(decide(counts, rates, rule).score.max(initial=-np.inf)) for counts in clean]
    patterns = np.array([pattern for row in rows for pattern in row["pattern"]])
    epsilons = [row["epsilon"] for row in rows if row["epsilon"] is not None]
    distances = np.sort([pair for row in rows for pair in row["pairs"]])
    of_clean = [each for row in rows for each in row["clean_distances"]]
    of_attacked = [each for _, row in attacked for each in row["distances"]]
    if not len(patterns) or not epsilons or not of_clean or not of_attacked:
        raise DataError("No surfaces of two vehicles could be compared: take more instants.")
    return ConnectedFit(
        ScanPattern(*(round(float(value), 3) for value in np.median(patterns, axis=0))),
        {**on.data, "instants": len(rows), "attacked": len(attacked)},
        rates,
        on.margins,
        see_through,
        calibration,
        tuple(sorted(round(score, 4) for score in highest)),
        round(float(np.mean(epsilons)), 4),
        tuple(distances.tolist()),
        fit_calibration(
            [*of_clean, *of_attacked], [False] * len(of_clean) + [True] * len(of_attacked)
        ),
    )


def _labelled(
    clean: list[NDArray[np.int64]], attacked: list[tuple[NDArray[np.int64], dict[str, Any]]]
) -> LabelledCounts:
    """Testimonies of what is there, and of what is not, or was removed."""
    present = [counts.reshape(-1, 3) for counts in clean]
    absent = []
    for counts, row in attacked:
        victim = row["victim"]
        about = counts[:, victim] if row["kind"] == "ghost" else counts[:, :, victim]
        absent.append(about.reshape(-1, 3))
    return LabelledCounts(
        np.concatenate([np.zeros((0, 3), np.int64), *present]),
        np.concatenate([np.zeros((0, 3), np.int64), *absent]),
    )


def _fitted_scores(
    clean: list[NDArray[np.int64]], attacked: list[NDArray[np.int64]], rates: RayRates
) -> tuple[float, ScoreProbability]:
    """How likely see-through things are, and the calibration, with the least logistic loss."""
    best: tuple[float, float, ScoreProbability] | None = None
    for see_through in _SEE_THROUGH:
        rule = DecisionRule(see_through=see_through)
        of_clean, of_attacked = (
            np.concatenate([decide(counts, rates, rule).score for counts in group])
            for group in (clean, attacked)
        )
        of_clean, of_attacked = (each[np.isfinite(each)] for each in (of_clean, of_attacked))
        if not len(of_clean) or not len(of_attacked):
            raise DataError("No testimony decides anything: take more instants.")
        truth = np.arange(len(of_clean) + len(of_attacked)) >= len(of_clean)
        scores = np.concatenate([of_clean, of_attacked])
        calibration = fit_calibration(scores, truth)
        odds = calibration.slope * scores + calibration.offset
        loss = float(np.logaddexp(0, np.where(truth, -odds, odds)).mean())
        if best is None or loss < best[0]:
            best = (loss, see_through, calibration)
    assert best is not None
    return best[1:]


def _listed(counts: NDArray[np.int64] | None) -> list[list[int]]:
    """Counts as rows of region, claimer, witness, and three numbers; the first is the shape."""
    assert counts is not None
    indices = np.argwhere(counts.any(axis=3))
    rows = np.concatenate([indices, counts[tuple(indices.T)]], axis=1)
    return [[len(counts)], *rows.tolist()]


def _dense(rows: list[list[int]], vehicles: int) -> NDArray[np.int64]:
    """The inverse of `_listed`."""
    counts = np.zeros((rows[0][0], vehicles, vehicles, 3), np.int64)
    for region, claimer, witness, *numbers in rows[1:]:
        counts[region, claimer, witness] = numbers
    return counts


def _pairs(distances: Floats | None) -> Floats:
    """The distances of all pairs that were compared, each once."""
    assert distances is not None
    upper = np.triu(np.ones(distances.shape[1:], bool), 1)
    pairs = distances[:, upper].ravel()
    return np.asarray(pairs[np.isfinite(pairs)])


def _largest(distances: Floats | None) -> list[float]:
    """The largest distance of each region in which something was compared."""
    assert distances is not None
    some = np.isfinite(distances).any(axis=(1, 2))
    return np.round(np.nanmax(distances[some], axis=(1, 2)), 3).tolist() if some.any() else []
