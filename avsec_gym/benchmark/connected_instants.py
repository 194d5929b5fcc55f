"""Judges the frozen instants of connected vehicles: an experiment, and the rows of an entry."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, get_args

import numpy as np

from avsec_gym.benchmark.adaptive_rows import AdaptiveRow, detection_row
from avsec_gym.benchmark.connected_scenes import CONNECTED, frozen_instants
from avsec_gym.benchmark.protocol import ADAPTIVE, UNATTACKED, places_in
from avsec_gym.benchmark.quiet_attacks import INSTANT_TRIES
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
        setting: ``unattacked``, the attack, ``ghost`` or ``removal``, or ``ghost adaptive`` and
            ``removal adaptive`` where the attacker knows the validator.
        instants: Number of instants; of an attack those that offer it something.
        alarms: Instants at which it alarms, wherever.
        honest_named: Instants at which it names a vehicle that is not attacked.
        detected: Attacks about which it alarms.
        decidable: Attacks that some other vehicle has rays enough to detect, by the package's
            method of rays.
        of_decidable: The share of these about which it alarms.
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
    attacks = [*ATTACKS, *map(adaptive_instants, ATTACKS)]
    return [
        InstantsRow(UNATTACKED, len(clean.places), clean.share(_ALARM), clean.share(_ACCUSED)),
        *(_attacked_row(kind, _State.of(run, kind), clean) for kind in attacks),
    ]


def instants_adaptive_rows(run: Results) -> list[AdaptiveRow]:
    """A row for each attack: adaptive beside listed, where another vehicle can detect both.

    Args:
        run: A run of `BENCHMARK_INSTANTS`.
    """
    rows = []
    for kind in ATTACKS:
        setting = adaptive_instants(kind)
        listed, under = (_State.of(run, name).decidable for name in (kind, setting))
        before, after = listed.detected, under.detected
        both = [place for place in after if place in before]
        changed = [float(after[place]) - float(before[place]) for place in both]
        detected = share_of([*after.values()], [*after])
        rows.append(detection_row(setting, kind, changed, both, detected))
    return rows


def adaptive_instants(kind: AttackKind) -> str:
    """The name of the setting in which the attacker knows the validator."""
    return f"{kind} {ADAPTIVE}"


@dataclass(frozen=True)
class _State:
    """What was measured of a state: values by name, of each of its places."""

    places: Sequence[str]
    values: Mapping[str, Sequence[float]]

    @classmethod
    def of(cls, run: Results, setting: str) -> _State:
        """The state of a setting at the places that offered the attack something."""
        found: dict[str, dict[str, float]] = {}
        for row in run.measurements(setting=setting):
            # A run knows no infinity: nothing is -inf.
            value = -np.inf if np.isnan(row.value) else row.value
            found.setdefault(row.scenario, {})[row.name] = value
        kept = {place: own for place, own in sorted(found.items()) if own[_ATTACKED]}
        names = (_DECIDABLE, _ALARM, _ACCUSED, _SCORE, _ANSWER)
        values = {name: [own[name] for own in kept.values()] for name in names}
        return cls([*kept], values)

    @property
    def scores(self) -> ClusteredScores:
        return ClusteredScores(np.array(self.values[_SCORE], float), self.places)

    @property
    def decidable(self) -> _State:
        """The attacks that another vehicle can detect."""
        kept = np.flatnonzero(self.values[_DECIDABLE]).tolist()
        values = {name: [own[i] for i in kept] for name, own in self.values.items()}
        return _State([self.places[i] for i in kept], values)

    @property
    def detected(self) -> dict[str, bool]:
        """Whether there is an alarm about the attack, by place."""
        answers = zip(self.places, self.values[_ANSWER], strict=True)
        return {place: answer != Naming.NO_ALARM for place, answer in answers}

    def share(self, name: str) -> Share:
        return share_of([value > 0 for value in self.values[name]], self.places)

    def answers(self, *answers: Naming) -> Share:
        return share_of([value in answers for value in self.values[_ANSWER]], self.places)


def _attacked_row(kind: str, state: _State, clean: _State) -> InstantsRow:
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
        """The validator that decides which attacks another vehicle sees."""
        return rays_validator()

    def __call__(self, number: int) -> CellResult:
        """The results of one cell.

        Args:
            number: Number of the place.

        Raises:
            ConfigurationError: This release makes another place.
        """
        instant = self._frozen.instant(number)
        measured = _measured(UNATTACKED, instant.id, self._values(instant, None))
        for index, (kind, attack) in enumerate(self._attacks.items()):
            seed = (self._frozen.seed, number, index)
            listed = attack.attack(instant, seed)
            if listed is None:
                every = (kind, adaptive_instants(kind))
                measured += [Measurement(each, instant.id, _ATTACKED, 0.0) for each in every]
                continue
            found = self._values(listed.instant, listed)
            measured += _measured(kind, instant.id, found)
            for attempt in range(1, INSTANT_TRIES):
                found = self._quieter(found, attack.attack(instant, (*seed, attempt)))
            measured += _measured(adaptive_instants(kind), instant.id, found)
        return CellResult(measurements=measured)

    def _quieter(self, best: _Values, attacked: AttackedInstant | None) -> _Values:
        """The attempt that another vehicle can detect, but the validator is least sure of.

        Where no vehicle has rays enough no validator can: such attempts prove nothing.
        """
        if attacked is None or not self._is_decidable(attacked):
            return best
        found = self._values(attacked.instant, attacked, decidable=True)
        return found if not best[_DECIDABLE] or _loudness(found) < _loudness(best) else best

    def _values(
        self,
        instant: RecordedInstant,
        attacked: AttackedInstant | None,
        *,
        decidable: bool | None = None,
    ) -> _Values:
        """What is kept of an instant in one state.

        Args:
            instant: The instant, attacked or not.
            attacked: The attack on it; None: there is none.
            decidable: Whether another vehicle can detect the attack; None: it is asked.
        """
        judged = self._validator.validate(instant.scans, id=instant.id)
        named, victim = judged.named, -1 if attacked is None else attacked.victim
        about = np.ones(len(named), bool) if attacked is None else attacked.regions(judged.regions)
        score = float(judged.score[about].max(initial=-np.inf))
        if decidable is None:
            decidable = attacked is not None and self._is_decidable(attacked)
        return {
            _ATTACKED: 1.0,
            _ALARM: float((named != NO_ATTACK).any()),
            _ACCUSED: float(((named >= 0) & (named != victim)).any()),
            _SCORE: score if np.isfinite(score) else float("nan"),
            _DECIDABLE: float(decidable),
            _ANSWER: float(_answer(judged, about, victim)),
        }

    def _is_decidable(self, attacked: AttackedInstant) -> bool:
        instant = attacked.instant
        result = self._rays.validate(instant.scans, id=instant.id)
        return bool((attacked.regions(result.regions) & result.decidable).any())


_Values = dict[str, float]
"""What is kept of an instant in one state, by name."""


def _measured(setting: str, id: str, values: _Values) -> list[Measurement]:
    return [Measurement(setting, id, *each) for each in values.items()]


def _loudness(values: _Values) -> tuple[bool, float]:
    """Whether the validator alarms about an attack, and then its score."""
    score = values[_SCORE]
    return values[_ANSWER] != Naming.NO_ALARM, -np.inf if np.isnan(score) else score


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
