"""Judges the frozen instants of connected vehicles: an experiment, and the rows of an entry."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, get_args

import numpy as np

from avsec_gym.benchmark.connected_scenes import CONNECTED, frozen_instants
from avsec_gym.benchmark.protocol import UNATTACKED, places_in
from avsec_gym.experiments.json_rows import OPTIONAL
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.metrics.estimate import Estimate
from avsec_gym.metrics.roc_curve import ClusteredScores, roc_area, threshold_at
from avsec_gym.registry import Kind, make
from avsec_gym.runs.experiment import Cell, CellResult, Configuration, Experiment, Measurement
from avsec_gym.runs.results import Results
from avsec_gym.validation.connected.attacks.attacked_instant import AttackedInstant, InstantAttack
from avsec_gym.validation.connected.attacks.pasted_object import PastedObject
from avsec_gym.validation.connected.attacks.removed_object import RemovedObject
from avsec_gym.validation.connected.fit import SHIPPED_FIT
from avsec_gym.validation.connected.named_validators import (
    InstantValidator,
    JudgedRegions,
    rays_validator,
)
from avsec_gym.validation.connected.rays.decision import CANNOT_TELL, NO_ATTACK
from avsec_gym.validation.connected.recordings import RecordedInstant
from avsec_gym.validation.connected.result import AttackKind, Naming
from avsec_gym.validation.connected.validator import ConnectedValidator

OPTIONS = {"part": {"name": "rays"}, "quick": False, "world": ""}
"""The validator, whether only the instants of a quick entry are judged, and the fingerprint of the
world that makes them."""
FALSE_ALARMS = 0.1
"""Share of the attack-free instants whose scores exceed the threshold of `InstantsRow.at_rate`."""
ATTACKS: tuple[AttackKind, ...] = get_args(AttackKind)
_WORK = "avsec_gym.benchmark.connected_instants:BenchmarkInstants"
_ATTACKED, _DECIDABLE, _ALARM = "attacked", "decidable", "alarm"
_ACCUSED, _SCORE, _ANSWER = "honest accused", "score", "answer"


@dataclass(frozen=True)
class InstantsRow:
    """A state of the instants; each place is one instant, and a cluster of the intervals.

    Args:
        setting: ``unattacked``, or the attack: ``ghost`` or ``removal``.
        instants: Number of instants; of an attack those that offer it something.
        alarms: Instants at which it alarms, wherever.
        honest_named: Instants at which it names a vehicle that is not attacked.
        detected: Attacks about which it alarms.
        decidable: Attacks of which some other vehicle has rays enough to tell, as of the package's
            method of rays.
        of_decidable: Of these, those about which it alarms.
        victim: Attacks of which it names the victim, and no other vehicle.
        another: Attacks of which it names another vehicle.
        cannot_tell: Attacks about which it alarms, but cannot tell whose LiDAR it is.
        area: The area under the ROC curve, of decidable attacks by their highest score and of
            attack-free instants by theirs.
        at_rate: Decidable attacks above the score that `FALSE_ALARMS` of the attack-free instants
            exceed.
    """

    setting: str
    instants: int
    alarms: Share
    honest_named: Share
    detected: Share | None = field(default=None, metadata=OPTIONAL)
    decidable: Share | None = field(default=None, metadata=OPTIONAL)
    of_decidable: Share | None = field(default=None, metadata=OPTIONAL)
    victim: Share | None = field(default=None, metadata=OPTIONAL)
    another: Share | None = field(default=None, metadata=OPTIONAL)
    cannot_tell: Share | None = field(default=None, metadata=OPTIONAL)
    area: Estimate | None = field(default=None, metadata=OPTIONAL)
    at_rate: Share | None = field(default=None, metadata=OPTIONAL)


def instants_rows(run: Results) -> list[InstantsRow]:
    """The rows of a run of `BENCHMARK_INSTANTS`: without an attack, then of each attack."""
    clean = _State.of(run, UNATTACKED)
    return [
        InstantsRow(UNATTACKED, len(clean.places), clean.share(_ALARM), clean.share(_ACCUSED)),
        *(_attacked_row(kind, _State.of(run, kind), clean) for kind in ATTACKS),
    ]


@dataclass(frozen=True)
class _State:
    """What was measured of a state: values by name, of each of its places."""

    places: Sequence[str]
    values: Mapping[str, Sequence[float]]

    @classmethod
    def of(cls, run: Results, setting: str) -> _State:
        """Without the places that offered the attack nothing."""
        found: dict[str, dict[str, float]] = {}
        for row in run.measurements(setting=setting):
            # A run knows no infinity: nothing is -inf.
            value = -np.inf if row["value"] is None else row["value"]
            found.setdefault(row["scenario"], {})[row["name"]] = value
        kept = {place: own for place, own in sorted(found.items()) if own[_ATTACKED]}
        names = (_DECIDABLE, _ALARM, _ACCUSED, _SCORE, _ANSWER)
        values = {name: [own[name] for own in kept.values()] for name in names}
        return cls([*kept], values)

    @property
    def scores(self) -> ClusteredScores:
        return ClusteredScores(np.array(self.values[_SCORE], float), self.places)

    @property
    def decidable(self) -> _State:
        """Those of which another vehicle can tell."""
        kept = np.flatnonzero(self.values[_DECIDABLE]).tolist()
        values = {name: [own[i] for i in kept] for name, own in self.values.items()}
        return _State([self.places[i] for i in kept], values)

    def share(self, name: str) -> Share:
        return share_of([value > 0 for value in self.values[name]], self.places)

    def answers(self, *answers: Naming) -> Share:
        return share_of([value in answers for value in self.values[_ANSWER]], self.places)


def _attacked_row(kind: AttackKind, state: _State, clean: _State) -> InstantsRow:
    decidable, alarmed = state.decidable, [each for each in Naming if each != Naming.NO_ALARM]
    scores, of_clean = decidable.scores, clean.scores
    area = roc_area(scores, of_clean)
    threshold = threshold_at(of_clean.scores, FALSE_ALARMS)
    return InstantsRow(
        kind,
        len(state.places),
        state.share(_ALARM),
        state.share(_ACCUSED),
        detected=state.answers(*alarmed),
        decidable=state.share(_DECIDABLE),
        of_decidable=decidable.answers(*alarmed),
        victim=state.answers(Naming.VICTIM),
        another=state.answers(Naming.ANOTHER),
        cannot_tell=state.answers(Naming.CANNOT_TELL),
        area=Estimate(area.value, area.interval),
        at_rate=share_of(scores.scores > threshold, scores.clusters),
    )


def _cells(configuration: Configuration) -> list[Cell]:
    """A cell for every instant."""
    numbers = frozen_instants().numbers(quick=bool(configuration.options["quick"]))
    return [Cell.of(_WORK, str(number), number=number) for number in numbers]


def _inputs(configuration: Configuration) -> dict[str, Path]:
    return {"connected fit": SHIPPED_FIT, **places_in(configuration.options["part"])}


class BenchmarkInstants:
    """Judges an instant in all states; see `avsec_gym.runs.experiment.Work`.

    Args:
        configuration: The configuration of the run.

    Raises:
        ConfigurationError: There is no such validator.
    """

    def __init__(self, configuration: Configuration) -> None:
        self._frozen = frozen_instants()
        self._validator: InstantValidator = make(
            Kind.CONNECTED_VALIDATOR, configuration.options["part"]
        )
        self._attacks: dict[AttackKind, InstantAttack] = {
            "ghost": PastedObject(),
            "removal": RemovedObject(),
        }

    @cached_property
    def _rays(self) -> ConnectedValidator:
        """What tells which attacks another vehicle sees."""
        return rays_validator()

    def __call__(self, number: int) -> CellResult:
        """The results of one cell.

        Args:
            number: Number of the place.

        Raises:
            ConfigurationError: This release makes another place.
        """
        instant = self._frozen.instant(number)
        measured = self._measured(UNATTACKED, instant, None)
        for index, (kind, attack) in enumerate(self._attacks.items()):
            attacked = attack.attack(instant, (self._frozen.seed, number, index))
            if attacked is None:
                measured.append(Measurement(kind, instant.id, _ATTACKED, 0.0))
            else:
                measured += self._measured(kind, attacked.instant, attacked)
        return CellResult(measurements=measured)

    def _measured(
        self, setting: str, instant: RecordedInstant, attacked: AttackedInstant | None
    ) -> list[Measurement]:
        """What is kept of an instant in one state."""
        judged = self._validator.validate(instant.scans, id=instant.id)
        named, victim = judged.named, -1 if attacked is None else attacked.victim
        about = np.ones(len(named), bool) if attacked is None else attacked.regions(judged.regions)
        score = float(judged.score[about].max(initial=-np.inf))
        values = {
            _ATTACKED: 1.0,
            _ALARM: float((named != NO_ATTACK).any()),
            _ACCUSED: float(((named >= 0) & (named != victim)).any()),
            _SCORE: score if np.isfinite(score) else float("nan"),
            _DECIDABLE: float(attacked is not None and self._is_decidable(attacked)),
            _ANSWER: float(_answer(judged, about, victim)),
        }
        return [Measurement(setting, instant.id, *each) for each in values.items()]

    def _is_decidable(self, attacked: AttackedInstant) -> bool:
        instant = attacked.instant
        result = self._rays.validate(instant.scans, id=instant.id)
        return bool((attacked.regions(result.regions) & result.decidable).any())


def _answer(judged: JudgedRegions, about: Any, victim: int) -> Naming:
    named = set(judged.named[about].tolist()) - {NO_ATTACK}
    if named - {victim, CANNOT_TELL}:
        return Naming.ANOTHER
    if victim in named:
        return Naming.VICTIM
    return Naming.CANNOT_TELL if named else Naming.NO_ALARM


BENCHMARK_INSTANTS = Experiment(
    "benchmark_instants",
    "Does this validator find the vehicle that is lied to?",
    "",
    _cells,
    inputs=_inputs,
    options=OPTIONS,
    usual=Configuration(CONNECTED),
)
