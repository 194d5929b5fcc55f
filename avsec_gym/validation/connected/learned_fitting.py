"""Fits the learned comparison to instants that are never judged, attack-free and attacked."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.geometry import Floats
from avsec_gym.metrics.roc_curve import ClusteredScores, roc_area
from avsec_gym.progress import Progress
from avsec_gym.validation.connected.budget import MessageBudget
from avsec_gym.validation.connected.fit import ConnectedFit
from avsec_gym.validation.connected.fitting import FittedInstants
from avsec_gym.validation.connected.learned.exchange import exchange_both
from avsec_gym.validation.connected.learned.features import region_features
from avsec_gym.validation.connected.learned.learned_fit import LearnedCard, LearnedFit
from avsec_gym.validation.connected.learned.logistic_model import LogisticModel, fit_logistic
from avsec_gym.validation.connected.recordings import RecordedInstant
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.surfaces.delaunay import delaunay_mesh
from avsec_gym.validation.connected.vehicle_scan import VehicleScan

PENALTY, FOLDS = 1.0, 5


@dataclass(frozen=True, eq=False)
class LearnedSamples:
    """Regions of which the truth is known.

    Args:
        features: The features of the regions, shape (N, F).
        attacked: Whether each was attacked, shape (N,).
        instant: Number of the instant of each, shape (N,).
        instants: How many instants there are; in some of them nothing may be compared.
    """

    features: Floats
    attacked: NDArray[np.bool_]
    instant: NDArray[np.int64]
    instants: int


def fit_learned(
    instants: Iterable[RecordedInstant],
    count: int,
    on: FittedInstants,
    constants: ConnectedFit,
    *,
    on_progress: Progress | None = None,
) -> LearnedFit:
    """Measure instants attack-free and attacked, and fit a model to their regions.

    Args:
        instants: Instants without an attack, two or more vehicles each.
        count: Number of them.
        on: What they are, and how they are attacked.
        constants: What rays and surfaces are worth.
        on_progress: Callback after each instant.

    Raises:
        DataError: Too few regions of a kind were compared.
    """
    features, attacked, numbers, done = [], [], [], 0
    for number, instant in enumerate(instants):
        rows, of_attack = _measured(instant, number, on, constants)
        features.append(rows)
        attacked.append(of_attack)
        numbers.append(np.full(len(rows), number))
        done = number + 1
        if on_progress is not None:
            on_progress(done, count)
    if not done:
        raise DataError("There was no instant to learn from.")
    samples = LearnedSamples(
        np.concatenate(features), np.concatenate(attacked), np.concatenate(numbers), done
    )
    return fit_of_samples(samples, on, constants.origin)


def fit_of_samples(
    samples: LearnedSamples,
    on: FittedInstants,
    constants: str,
    penalty: float = PENALTY,
    folds: int = FOLDS,
) -> LearnedFit:
    """The model of all samples, with what models are worth that lacked a part of the instants.

    Args:
        samples: Regions of which the truth is known.
        on: What the instants are.
        constants: What the ratios among the features were fitted on, in words.
        penalty: How much large weights cost, as of `fit_logistic`.
        folds: Number of parts of the instants, each of which is held out once.

    Raises:
        DataError: Attacked regions of fewer than two instants, or too few instants.
        ConfigurationError: Fewer than two folds.
    """
    if folds < 2:
        raise ConfigurationError(f"instants are held out in 2 folds or more, got {folds}")
    if samples.instants < folds or len(set(samples.instant[samples.attacked].tolist())) < 2:
        raise DataError(
            f"A model is learned from {folds} instants or more, with attacked regions in several.",
            remedy="Take more instants.",
        )
    # The log odds of each region by a model that lacked its instant.
    odds = np.empty(len(samples.attacked))
    for fold in range(folds):
        held_out = samples.instant % folds == fold
        odds[held_out] = _fitted(samples, ~held_out, penalty).log_odds(samples.features[held_out])
    # The highest of each instant's attack-free regions, by which alarms are chosen.
    truth = samples.attacked
    clean = [
        float(odds[~truth & (samples.instant == number)].max(initial=-np.inf))
        for number in range(samples.instants)
    ]
    # What the held-out odds are worth, for the card.
    of = [str(number) for number in samples.instant.tolist()]
    area = roc_area(
        ClusteredScores(odds[truth], [of[i] for i in np.flatnonzero(truth)]),
        ClusteredScores(odds[~truth], [of[i] for i in np.flatnonzero(~truth)]),
    ).value
    assert area is not None
    loss = float(np.logaddexp(0, np.where(truth, -odds, odds)).mean())
    card = LearnedCard(
        {**on.data, "instants": samples.instants},
        constants,
        int(truth.sum()),
        int((~truth).sum()),
        penalty,
        folds,
        round(area, 4),
        round(loss, 4),
    )
    # The model that is kept lacks nothing.
    return LearnedFit(
        _fitted(samples, np.ones(len(truth), bool), penalty),
        tuple(sorted(round(each, 4) for each in clean)),
        card,
    )


def _fitted(samples: LearnedSamples, chosen: NDArray[np.bool_], penalty: float) -> LogisticModel:
    return fit_logistic(samples.features[chosen], samples.attacked[chosen], penalty)


def _measured(
    instant: RecordedInstant, number: int, on: FittedInstants, constants: ConnectedFit
) -> tuple[Floats, NDArray[np.bool_]]:
    """Features of an instant's regions, and of those about what is attacked in it."""
    decides = constants.constants()

    def compared(scans: tuple[VehicleScan, ...]) -> tuple[Floats, NDArray[np.bool_], Regions]:
        heard = exchange_both(scans, decides, on.proposer, delaunay_mesh, MessageBudget())
        features = region_features(heard.evidence, decides.rates, decides.rule)
        return features, heard.evidence.compared(decides.rates), heard.evidence.regions

    constants.check(instant.scans)
    features, some, _ = compared(instant.scans)
    found, truth = [features[some]], [np.zeros(int(some.sum()), bool)]
    for index, attack in enumerate(on.attacks):
        attacked = attack.attack(instant, (on.seed, number, index))
        if attacked is not None:
            features, some, regions = compared(attacked.instant.scans)
            about = some & attacked.regions(regions)
            found.append(features[about])
            truth.append(np.ones(int(about.sum()), bool))
    return np.concatenate(found), np.concatenate(truth)
