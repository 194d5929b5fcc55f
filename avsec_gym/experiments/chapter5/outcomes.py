"""A run of chapter 5, read: safety and precision of each condition on the same scenarios."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter5.settings import (
    ATTACKS,
    DETECTORS,
    PERTURBATIONS,
    STEPS,
    TEXTURE_ATTACKED,
    UNATTACKED,
    WHOLE_LEVELS,
    setting,
    specific,
)
from avsec_gym.experiments.chapter5.true_episodes import GROUND_TRUTH
from avsec_gym.experiments.json_rows import row_of
from avsec_gym.metrics.average_precision import (
    STANDARD_IOU,
    AveragePrecision,
    MinIou,
    average_precision,
)
from avsec_gym.metrics.safety import SafetyRates, SafetyRecord
from avsec_gym.planners.planner import Algorithm
from avsec_gym.runs.results import Results
from avsec_gym.scenario.intention import Intention

RESAMPLES = 1000
CATEGORY = "Car"
_ENOUGH = 0.5


@dataclass(frozen=True, order=True)
class Condition:
    """A detector under an attack.

    Args:
        detector: The detector's name.
        attack: The attack, see `avsec_gym.experiments.chapter5.settings`.
        strength: Steps of a perturbation, n.
        whole_levels: Whether attacked pixels were rounded.
    """

    detector: str
    attack: str = UNATTACKED
    strength: float = 0.0
    whole_levels: bool = False

    def columns(self, key: str) -> dict[str, object]:
        """Its fields, among the columns of a row; see `json_rows`."""
        return dict(vars(self))

    @classmethod
    def of_columns(cls, key: str, columns: Mapping[str, Any]) -> Condition:
        """The condition that these columns describe."""
        return row_of(cls, columns)

    @property
    def setting(self) -> str:
        """The setting of its episodes."""
        return setting(self.detector, self.attack, whole_levels=self.whole_levels)

    @property
    def unattacked(self) -> Condition:
        """The same detector without an attack."""
        return Condition(self.detector)


@dataclass(frozen=True, eq=False)
class Outcomes:
    """The outcomes of a run, on the scenarios that every condition was done for.

    While a run goes on, a condition of which little is done would leave hardly any scenario for
    the others: those with less than half as many scenarios as the most are `left_out`.

    Args:
        results: The results of the run.
        labels: The labels of each scenario, DontCare regions among them.
        detectors: The detectors whose conditions count, in this order.
        attacks: The attacks whose conditions count, in this order.
    """

    results: Results
    labels: Mapping[str, Boxes3D]
    detectors: tuple[str, ...] = DETECTORS
    attacks: tuple[str, ...] = ATTACKS
    _detections: dict[tuple[str, float], list[Boxes3D]] = field(
        default_factory=dict, init=False, repr=False
    )
    _precisions: dict[tuple[Condition, Intention | None, float, int], AveragePrecision] = field(
        default_factory=dict, init=False, repr=False
    )

    @cached_property
    def conditions(self) -> tuple[Condition, ...]:
        """Every detector and attack that counts, detector by detector."""
        most = max((len(done) for done in self._done.values()), default=0)
        return tuple(
            condition for condition, done in self._done.items() if len(done) >= _ENOUGH * most
        )

    @property
    def strongest(self) -> tuple[Condition, ...]:
        """The conditions without earlier steps of perturbations and without whole grey levels."""
        stepwise = (*PERTURBATIONS, TEXTURE_ATTACKED)
        return tuple(
            condition
            for condition in self.conditions
            if not condition.whole_levels
            and not (condition.attack in stepwise and condition.strength < STEPS)
        )

    @cached_property
    def left_out(self) -> dict[Condition, int]:
        """Conditions with too few scenarios to be compared, and how many they have."""
        return {
            condition: len(done)
            for condition, done in self._done.items()
            if condition not in self.conditions
        }

    @cached_property
    def scenarios(self) -> tuple[str, ...]:
        """The scenarios that no condition lacks, sorted; those of the truth without conditions."""
        there = set(self.labels)
        for condition in self.conditions:
            there &= self._done[condition]
        if not self.conditions:
            there &= {record.scenario for record in self.results.records(setting=GROUND_TRUTH)}
        return tuple(sorted(there))

    def records(
        self, condition: Condition, intention: Intention | None = None
    ) -> list[SafetyRecord]:
        """Records of one intention, or of all, in the order of scenarios."""
        kept = self._kept
        return [
            record
            for record in self._all_records.get(condition, [])
            if record.scenario in kept and intention in (None, record.intention)
        ]

    def true_records(self, planner: Algorithm, intention: Intention) -> list[SafetyRecord]:
        """Records of episodes on the ground truth, in the order of scenarios."""
        kept = self._kept
        every = self.results.records(
            setting=GROUND_TRUTH, planner=str(planner), intention=str(intention)
        )
        return [record for record in every if record.scenario in kept]

    def rates(self, condition: Condition, intention: Intention | None = None) -> SafetyRates:
        """Success, collision and safe driving rate."""
        return SafetyRates.of(self.records(condition, intention))

    def detections(self, condition: Condition, intention: Intention | None = None) -> list[Boxes3D]:
        """What is seen in each scenario; under a specific attack it depends on the intention."""
        attack = condition.attack if intention is None else specific(condition.attack, intention)
        name = setting(condition.detector, attack, whole_levels=condition.whole_levels)
        key = (name, condition.strength)
        if key not in self._detections:
            found = self.results.detections(*key)
            self._detections[key] = [found[scenario] for scenario in self.scenarios]
        return self._detections[key]

    def looks(self, condition: Condition) -> tuple[Intention | None, ...]:
        """The key of its detections: the intentions where they matter, else None."""
        name = specific(condition.attack, Intention.STRAIGHT)
        apart = (setting(condition.detector, name), condition.strength) in self._settings
        return tuple(Intention) if apart else (None,)

    def precision(
        self,
        condition: Condition,
        intention: Intention | None = None,
        min_iou: MinIou = STANDARD_IOU,
        resamples: int = RESAMPLES,
    ) -> AveragePrecision:
        """Average precision of cars, with bootstrap samples of scenarios."""
        key = (condition, intention, min_iou[CATEGORY][2], resamples)
        if key not in self._precisions:
            self._precisions[key] = average_precision(
                [self.labels[scenario] for scenario in self.scenarios],
                self.detections(condition, intention),
                classes=(CATEGORY,),
                min_iou=min_iou,
                resamples=resamples,
            )
        return self._precisions[key]

    @cached_property
    def _settings(self) -> set[tuple[str, float]]:
        return set(self.results.settings())

    @cached_property
    def _all_records(self) -> dict[Condition, list[SafetyRecord]]:
        found = {}
        for name, strength in self.results.settings():
            detector, _, attack = name.partition(" ")
            whole = attack.endswith(WHOLE_LEVELS)
            attack = attack.removesuffix(WHOLE_LEVELS).strip()
            if detector in self.detectors and attack in self.attacks:
                records = self.results.records(setting=name, strength=strength)
                found[Condition(detector, attack, strength, whole)] = records
        return {condition: found[condition] for condition in sorted(found, key=self._place)}

    @cached_property
    def _done(self) -> dict[Condition, set[str]]:
        """The labelled scenarios of every condition that has episodes there."""
        done = {
            condition: {record.scenario for record in records} & set(self.labels)
            for condition, records in self._all_records.items()
        }
        return {condition: scenarios for condition, scenarios in done.items() if scenarios}

    @cached_property
    def _kept(self) -> frozenset[str]:
        return frozenset(self.scenarios)

    def _place(self, condition: Condition) -> tuple[int, bool, int, float]:
        return (
            self.detectors.index(condition.detector),
            condition.whole_levels,
            self.attacks.index(condition.attack),
            condition.strength,
        )


def safe_by_scenario(
    records: Sequence[SafetyRecord], scenarios: Sequence[str]
) -> NDArray[np.int64]:
    """Safe episodes and episodes of each scenario, shape (S, 2)."""
    row = {scenario: number for number, scenario in enumerate(scenarios)}
    counts = np.zeros((len(scenarios), 2), np.int64)
    for record in records:
        counts[row[record.scenario]] += (record.safe, 1)
    return counts
