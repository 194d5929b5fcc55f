"""The work of chapter 4: an instant under one condition, attack-free and attacked."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter4.clean_rays import CleanRays
from avsec_gym.experiments.chapter4.compared_instant import compared_instant
from avsec_gym.experiments.chapter4.procedural_instants import ScannedPlace
from avsec_gym.experiments.chapter4.settings import (
    ATTACKS,
    CLEAN,
    CONDITIONS,
    JUDGED,
    OPTIONS,
    STATES_OF,
    USUAL,
    ConnectedCondition,
    Part,
)
from avsec_gym.experiments.chapter4.state_rows import rows_of, setting_of
from avsec_gym.experiments.chapter4.states_of_instants import (
    attacked_state,
    clean_state,
    nothing_to_attack,
)
from avsec_gym.experiments.chapter4.step_times import seconds_of_steps
from avsec_gym.experiments.procedural_frames import PROCEDURAL
from avsec_gym.runs.experiment import Cell, CellResult, Configuration
from avsec_gym.validation.connected.attacks.attacked_instant import InstantAttack
from avsec_gym.validation.connected.attacks.pasted_object import PastedObject
from avsec_gym.validation.connected.attacks.removed_object import RemovedObject
from avsec_gym.validation.connected.constants import ConnectedConstants
from avsec_gym.validation.connected.fit import SHIPPED_FIT, ConnectedFit, read_connected_fit
from avsec_gym.validation.connected.learned.learned_fit import SHIPPED_MODEL, read_learned_fit
from avsec_gym.validation.connected.proposals.clusters import ClusterProposer
from avsec_gym.validation.connected.proposals.remembered import RememberedProposals
from avsec_gym.validation.connected.result import AttackKind

USUAL_COUNT = 200
_WORK = f"{__name__}:ConnectedInstants"
_FORMAT = 5
"""Raised when what is measured changes, so that cells are done again."""
_ATTACKS: dict[AttackKind, InstantAttack] = {
    "ghost": PastedObject(),
    "removal": RemovedObject(),
}


def connected_cells(configuration: Configuration) -> list[Cell]:
    """A cell for every place and condition; places to fit on and to judge take turns.

    Raises:
        ConfigurationError: Data other than procedural ones, or a condition that there is not.
    """
    if configuration.scenarios != PROCEDURAL:
        raise ConfigurationError(
            f"chapter4 judges places of the procedural world: --scenarios is {PROCEDURAL!r}, got"
            f" {configuration.scenarios!r}; `avsec connected --data` judges other data"
        )
    if not 0 <= configuration.seed < 1000:
        raise ConfigurationError(f"a seed of places is from 0 to 999, got {configuration.seed}")
    return [
        Cell.of(
            _WORK,
            f"{part} {number}",
            part=part,
            number=number,
            condition=CONDITIONS.index(condition),
            format=_FORMAT,
        )
        for number in range(configuration.limit or USUAL_COUNT)
        for part in STATES_OF
        for condition in conditions_of(configuration)
    ]


def conditions_of(configuration: Configuration) -> list[ConnectedCondition]:
    """The conditions that a run measures.

    Raises:
        ConfigurationError: There is no such condition.
    """
    chosen = {**OPTIONS, **configuration.options}["conditions"]
    places = range(len(CONDITIONS))
    if not all(type(place) is int and place in places for place in chosen):
        raise ConfigurationError(
            f"conditions are places from 0 to {len(CONDITIONS) - 1}, got {chosen!r}"
        )
    return [CONDITIONS[place] for place in sorted(set(chosen or places))]


def connected_inputs(configuration: Configuration) -> dict[str, Path]:
    """The fit that constants come from, and the model of the learned comparison."""
    return {"constants": _fit_file(configuration), "model": _model_file(configuration)}


class ConnectedInstants:
    """Measures places under conditions.

    Args:
        configuration: The configuration of the run.

    Raises:
        DataError: The file of constants, or of the model, is missing or damaged.
    """

    def __init__(self, configuration: Configuration) -> None:
        self._fit = read_connected_fit(_fit_file(configuration))
        self._learned = read_learned_fit(_model_file(configuration)).rule()
        self._seed, self._proposer = configuration.seed, RememberedProposals()
        self._place: tuple[tuple[Part, int], ScannedPlace] | None = None
        self._warm = False

    def __call__(self, part: Part, number: int, condition: int, format: int) -> CellResult:
        """All states of an instant under a condition.

        Args:
            part: `FITTED` or `JUDGED`.
            number: Number of the place.
            condition: Place of the condition in `CONDITIONS`.
            format: Format of what is measured; cells of another one are done again.
        """
        begin = time.perf_counter()
        under = CONDITIONS[condition]
        instant = self._scanned(part, number).instant(under)
        self._fit.check(instant.scans)
        constants, rays = constants_under(self._fit, under), CleanRays(instant)
        if not self._warm:
            # Kernels are loaded when they are first called: that is no instant's time.
            compared_instant(instant.scans, constants, ClusterProposer(), self._learned)
            self._warm = True
        scanned = time.perf_counter()

        # Attack-free, which is all that thresholds need.
        compared = compared_instant(instant.scans, constants, self._proposer, self._learned)
        rows = rows_of(clean_state(instant.id, compared, rays), setting_of(part, under, CLEAN))
        seconds = {"scan": scanned - begin, f"judge {CLEAN}": time.perf_counter() - scanned}
        if part == JUDGED and under == USUAL:
            seconds |= seconds_of_steps(compared, under.vehicles)

        for index, kind in enumerate(ATTACKS if part == JUDGED else ()):
            begin = time.perf_counter()
            attacked = _ATTACKS[kind].attack(instant, (self._seed, number, index))
            state = nothing_to_attack(instant.id)
            if attacked is not None:
                compared = compared_instant(
                    attacked.instant.scans, constants, self._proposer, self._learned
                )
                state = attacked_state(instant.id, compared, attacked, rays)
            rows += rows_of(state, setting_of(part, under, kind))
            seconds[f"judge {kind}"] = time.perf_counter() - begin
        return CellResult(measurements=rows, seconds=seconds)

    def _scanned(self, part: Part, number: int) -> ScannedPlace:
        """The place, which cells of one group have in common."""
        if self._place is None or self._place[0] != (part, number):
            self._place = (part, number), ScannedPlace(self._seed, part, number)
        return self._place[1]


def constants_under(fit: ConnectedFit, condition: ConnectedCondition) -> ConnectedConstants:
    """What evidence is worth where vehicles know how much their poses err.

    Args:
        fit: The fit, which all conditions share.
        condition: The condition, whose errors of poses become those of the margins.
    """
    constants = fit.constants()
    noise = {
        "position_noise": condition.noise,
        "heading_noise": float(np.radians(condition.noise)),
    }
    return replace(constants, margins=replace(constants.margins, **noise))


def _fit_file(configuration: Configuration) -> Path:
    given = {**OPTIONS, **configuration.options}["constants"]
    return Path(given) if given else SHIPPED_FIT


def _model_file(configuration: Configuration) -> Path:
    given = {**OPTIONS, **configuration.options}["model"]
    return Path(given) if given else SHIPPED_MODEL
