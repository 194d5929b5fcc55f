"""A run of chapter 5, read: safety and precision of each condition on the same scenarios."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter5.settings import (
    DETECTORS,
    UNATTACKED,
    WHOLE_LEVELS,
    setting,
    specific,
)
from avsec_gym.experiments.results import Results
from avsec_gym.metrics.average_precision import (
    STANDARD_IOU,
    AveragePrecision,
    MinIou,
    average_precision,
)
from avsec_gym.metrics.safety import SafetyRates, SafetyRecord
from avsec_gym.scenario.intention import Intention

RESAMPLES = 1000
CATEGORY = "Car"


@dataclass(frozen=True, order=True)
class Condition:
    """A detector under an attack.

    Args:
        detector: Its name.
        attack: See `avsec_gym.experiments.chapter5.settings`.
        strength: Steps of a perturbation, n.
        whole_levels: Whether attacked pixels were rounded.
    """

    detector: str
    attack: str = UNATTACKED
    strength: float = 0.0
    whole_levels: bool = False

    @property
    def setting(self) -> str:
        """What its drives are filed under."""
        return setting(self.detector, self.attack, whole_levels=self.whole_levels)

    @property
    def unattacked(self) -> Condition:
        """The same detector, nobody attacking."""
        return Condition(self.detector)


@dataclass(frozen=True, eq=False)
class Outcomes:
    """What came out, on the scenarios that every condition was done for.

    Args:
        results: Of the run.
        labels: What is to be seen in each scenario, with the regions not to care about.
    """

    results: Results
    labels: Mapping[str, Boxes3D]

    @cached_property
    def conditions(self) -> tuple[Condition, ...]:
        """Every detector and attack that was driven under."""
        found = []
        for name, strength in self.results.settings():
            detector, _, attack = name.partition(" ")
            if detector in DETECTORS and self.results.records(setting=name, strength=strength):
                whole = attack.endswith(WHOLE_LEVELS)
                attack = attack.removesuffix(WHOLE_LEVELS).strip()
                found.append(Condition(detector, attack, strength, whole))
        return tuple(found)

    @cached_property
    def scenarios(self) -> tuple[str, ...]:
        """Those that no condition lacks, sorted."""
        there = set(self.labels)
        for condition in self.conditions:
            records = self.results.records(setting=condition.setting, strength=condition.strength)
            there &= {record.scenario for record in records}
        return tuple(sorted(there))

    def records(
        self,
        condition: Condition,
        intention: Intention | None = None,
        keep: Callable[[SafetyRecord], bool] = lambda record: True,
    ) -> list[SafetyRecord]:
        """Drives of one intention, or of all, in the order of scenarios."""
        where = {} if intention is None else {"intention": str(intention)}
        kept = set(self.scenarios)
        return [
            record
            for record in self.results.records(
                setting=condition.setting, strength=condition.strength, **where
            )
            if record.scenario in kept and keep(record)
        ]

    def rates(self, condition: Condition, intention: Intention | None = None) -> SafetyRates:
        """Success, collision and safe driving rate."""
        return SafetyRates.of(self.records(condition, intention))

    def detections(self, condition: Condition, intention: Intention | None = None) -> list[Boxes3D]:
        """What is seen in each scenario; under a specific attack it depends on the intention."""
        attack = condition.attack if intention is None else specific(condition.attack, intention)
        name = setting(condition.detector, attack, whole_levels=condition.whole_levels)
        found = self.results.detections(name, condition.strength)
        return [found[scenario] for scenario in self.scenarios]

    def looks(self, condition: Condition) -> tuple[Intention | None, ...]:
        """Under what its detections are filed: the intentions where they matter, else None."""
        plain = (condition.setting, condition.strength) in self.results.settings()
        seen = self.results.detections(condition.setting, condition.strength) if plain else {}
        return (None,) if seen else tuple(Intention)

    def precision(
        self,
        condition: Condition,
        intention: Intention | None = None,
        min_iou: MinIou = STANDARD_IOU,
    ) -> AveragePrecision:
        """Average precision of cars, with `RESAMPLES` bootstrap samples of scenarios."""
        return average_precision(
            [self.labels[scenario] for scenario in self.scenarios],
            self.detections(condition, intention),
            classes=(CATEGORY,),
            min_iou=min_iou,
            resamples=RESAMPLES,
        )


def safe_by_scenario(records: Sequence[SafetyRecord], scenarios: Sequence[str]) -> np.ndarray:
    """Safe drives and drives of each scenario, shape (S, 2)."""
    row = {scenario: number for number, scenario in enumerate(scenarios)}
    counts = np.zeros((len(scenarios), 2), int)
    for record in records:
        counts[row[record.scenario]] += (record.safe, 1)
    return counts
