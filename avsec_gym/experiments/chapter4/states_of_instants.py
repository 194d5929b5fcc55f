"""From all methods' results at an instant to what is kept of it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avsec_gym.experiments.chapter4.compared_instant import ComparedInstant
from avsec_gym.experiments.chapter4.measured_state import MeasuredState
from avsec_gym.experiments.chapter4.settings import METHODS
from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.attacks.attacked_instant import AttackedInstant
from avsec_gym.validation.connected.rays.decision import CANNOT_TELL, NO_ATTACK
from avsec_gym.validation.connected.result import Naming

_NONE = np.zeros(0, np.int64)


def clean_state(place: str, compared: ComparedInstant) -> MeasuredState:
    """All regions of an attack-free instant.

    Args:
        place: Name of the place.
        compared: The instant by all methods.
    """
    vehicles = compared.distances.shape[1]
    upper = np.triu(np.ones((vehicles, vehicles), bool), 1)
    return MeasuredState(
        place,
        False,
        compared.decidable,
        {method: compared.results[method].score for method in METHODS},
        dict.fromkeys(METHODS, _NONE),
        _known(compared.distances[:, upper]),
        {method: np.array(compared.results[method].nbytes) for method in METHODS},
    )


def attacked_state(
    place: str, compared: ComparedInstant, attacked: AttackedInstant
) -> MeasuredState:
    """The regions about what was attacked.

    Args:
        place: Name of the place.
        compared: The attacked instant by all methods.
        attacked: The attack.
    """
    about = attacked.regions(compared.regions)
    return MeasuredState(
        place,
        True,
        compared.decidable[about],
        {method: compared.results[method].score[about] for method in METHODS},
        {
            method: _namings(compared.results[method].named[about], attacked.victim)
            for method in METHODS
        },
        _known(compared.distances[about, attacked.victim]),
        dict.fromkeys(METHODS, _NONE),
    )


def nothing_to_attack(place: str) -> MeasuredState:
    """An instant that offers an attack nothing.

    Args:
        place: Name of the place.
    """
    nothing = np.zeros(0)
    return MeasuredState(
        place,
        False,
        np.zeros(0, bool),
        dict.fromkeys(METHODS, nothing),
        dict.fromkeys(METHODS, _NONE),
        nothing,
        dict.fromkeys(METHODS, _NONE),
    )


def _known(distances: Floats) -> Floats:
    """Those of pairs that were compared, shape (D,)."""
    flat = distances.ravel()
    return np.asarray(flat[np.isfinite(flat)])


def _namings(named: NDArray[np.int64], victim: int) -> NDArray[np.int64]:
    """`Naming` of each region."""
    return np.select(
        [named == NO_ATTACK, named == CANNOT_TELL, named == victim],
        [Naming.NO_ALARM, Naming.CANNOT_TELL, Naming.VICTIM],
        Naming.ANOTHER,
    ).astype(np.int64)
