"""From all methods' results at an instant to what is kept of it."""

from __future__ import annotations

import numpy as np

from avsec_gym.experiments.chapter4.clean_rays import CleanRays
from avsec_gym.experiments.chapter4.compared_instant import ComparedInstant
from avsec_gym.experiments.chapter4.measured_state import KnownAttack, MeasuredState
from avsec_gym.experiments.chapter4.settings import BY_GEOMETRY, BY_RAYS, METHODS, NAMERS
from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.attacks.attacked_instant import AttackedInstant
from avsec_gym.validation.connected.validator import Method

_NONE = np.zeros(0, np.int64)
_PROPOSING = "propose"
"""The step whose time stands by itself."""


def clean_state(place: str, compared: ComparedInstant, rays: CleanRays) -> MeasuredState:
    """All regions of an attack-free instant.

    Args:
        place: Name of the place.
        compared: The instant by all methods.
        rays: The rays of its scans from their true poses.
    """
    vehicles = compared.distances.shape[1]
    upper = np.triu(np.ones((vehicles, vehicles), bool), 1)
    distances = compared.distances[:, upper]
    return MeasuredState(
        place,
        None,
        {BY_GEOMETRY: rays.decidable(compared.regions), BY_RAYS: compared.decidable},
        {method: compared.results[method].score for method in METHODS},
        {method: compared.results[method].probability for method in METHODS},
        dict.fromkeys(NAMERS, _NONE),
        {namer: compared.named[namer].honest() for namer in NAMERS},
        _known(distances),
        distances.size,
        0,
        _seconds(compared),
        {str(kind): sent for kind, sent in compared.sent.items()},
        compared.from_station,
    )


def attacked_state(
    place: str, compared: ComparedInstant, attacked: AttackedInstant, rays: CleanRays
) -> MeasuredState:
    """The regions about what was attacked.

    Args:
        place: Name of the place.
        compared: The attacked instant by all methods.
        attacked: The attack.
        rays: The rays of the scans before the attack from their true poses.
    """
    about, victim = attacked.regions(compared.regions), attacked.victim
    attack = KnownAttack(rays.witnesses(attacked), attacked.distance, attacked.category)
    distances = np.delete(compared.distances[about, victim], victim, axis=1)
    return MeasuredState(
        place,
        attack,
        {
            BY_GEOMETRY: np.full(int(about.sum()), attack.witnesses > 0),
            BY_RAYS: compared.decidable[about],
        },
        {method: compared.results[method].score[about] for method in METHODS},
        {method: compared.results[method].probability[about] for method in METHODS},
        {namer: compared.named[namer].namings(victim)[about] for namer in NAMERS},
        {namer: compared.named[namer].honest(victim) for namer in NAMERS},
        _known(distances),
        distances.size,
        compared.witnesses(about, victim, attacked.kind),
        _seconds(compared),
        {},
        {},
    )


def nothing_to_attack(place: str) -> MeasuredState:
    """An instant that offers an attack nothing.

    Args:
        place: Name of the place.
    """
    nothing, no_region = np.zeros(0), np.zeros(0, bool)
    return MeasuredState(
        place,
        None,
        {BY_GEOMETRY: no_region, BY_RAYS: no_region},
        dict.fromkeys(METHODS, nothing),
        dict.fromkeys(METHODS, nothing),
        dict.fromkeys(NAMERS, _NONE),
        dict.fromkeys(NAMERS, 0),
        nothing,
        0,
        0,
        dict.fromkeys(METHODS, 0.0),
        {},
        {},
    )


def _known(distances: Floats) -> Floats:
    """Those of pairs that were compared, shape (D,)."""
    flat = distances.ravel()
    return np.asarray(flat[np.isfinite(flat)])


def _seconds(compared: ComparedInstant) -> dict[Method, float]:
    """CPU time of all steps but the proposals, of all vehicles and the base station."""
    return {
        method: sum(
            seconds
            for step, seconds in compared.results[method].seconds.items()
            if step != _PROPOSING
        )
        for method in METHODS
    }
