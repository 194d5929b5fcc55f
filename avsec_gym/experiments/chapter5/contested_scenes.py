"""The same figures where it matters what a car sees: contested scenes beside all scenes.

In most scenes a car that sees nothing drives as safely as one that sees all, and no attack can cost
anything by hiding cars.  `avsec_gym.evaluation.contested` has the rule: an episode is contested
that is unsafe for a blind car, and safe for one that sees all.  Safety counts the contested
episodes only; precision is that of the scenes which have one, whatever the intention.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any

from avsec_gym.boxes import Boxes3D
from avsec_gym.evaluation.contested import is_contested
from avsec_gym.experiments.chapter5.decoupling import Decoupling, decoupling
from avsec_gym.experiments.chapter5.families import FamilyFigures, family_figures
from avsec_gym.experiments.chapter5.outcomes import Condition, Outcomes
from avsec_gym.metrics.safety import SafetyRates, SafetyRecord
from avsec_gym.progress import Progress, no_progress
from avsec_gym.runs.experiment import Measurement
from avsec_gym.runs.results import Results
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Scene

ContestedEpisode = tuple[str, str]
"""Id of a scene, and a driving intention."""


@dataclass(frozen=True)
class ContestedRates:
    """A condition in all episodes or in contested ones, the intentions together.

    Args:
        condition: The detector under its attack.
        contested: Whether only contested episodes count.
        rates: The three rates; the episodes of a scene are a cluster.
    """

    condition: Condition
    contested: bool
    rates: SafetyRates


@dataclass(frozen=True)
class ContestedFigures:
    """What a run found in its contested scenes.

    Args:
        scenarios: Number of scenes that are contested with some intention.
        episodes: Number of contested episodes, scenes with one of their intentions.
        rates: The rates of every condition in all episodes, and in contested ones.
        decoupling: Losses of precision and of safety, and how far they go together.
        families: The same by family of attacks.
    """

    scenarios: int
    episodes: int
    rates: Sequence[ContestedRates]
    decoupling: Decoupling
    families: FamilyFigures


@dataclass(frozen=True)
class ContestedResults:
    """The results of a run, of its contested episodes only.

    Args:
        results: The results of the run.
        episodes: The episodes that count.
        left_out: Settings and strengths that were done for too few scenarios of the run, however
            many of these are contested.
    """

    results: Results
    episodes: Collection[ContestedEpisode]
    left_out: Collection[tuple[str, float]] = ()

    def settings(self) -> list[tuple[str, float]]:
        """See `Results`."""
        return [each for each in self.results.settings() if each not in self.left_out]

    def records(self, **where: Any) -> list[SafetyRecord]:
        """See `Results`; records of contested episodes."""
        return [
            record
            for record in self.results.records(**where)
            if (record.scenario, record.intention) in self.episodes
        ]

    def detections(self, setting: str, strength: float = 0.0) -> dict[str, Boxes3D]:
        """See `Results`."""
        return self.results.detections(setting, strength)

    def measurements(self, **where: Any) -> list[Measurement]:
        """See `Results`."""
        return self.results.measurements(**where)


def contested_episodes(
    outcomes: Outcomes,
    scenes: Sequence[Scene],
    on_progress: Progress = no_progress,
) -> frozenset[ContestedEpisode]:
    """The contested episodes of a run's scenarios.

    Args:
        outcomes: The outcomes of a run.
        scenes: The run's scenes, in any order, further ones among them.
        on_progress: Function that gets the number of scenarios that are done, and of all.
    """
    by_id = {scene.id: scene for scene in scenes}
    found = set()
    for number, scenario in enumerate(outcomes.scenarios):
        found |= {
            (scenario, str(intention))
            for intention in Intention
            if is_contested(by_id[scenario], intention)
        }
        on_progress(number + 1, len(outcomes.scenarios))
    return frozenset(found)


def contested_outcomes(outcomes: Outcomes, episodes: Collection[ContestedEpisode]) -> Outcomes:
    """The outcomes of a run in contested episodes.

    Args:
        outcomes: The outcomes of the run.
        episodes: The contested ones.
    """
    scenarios = sorted({scenario for scenario, _ in episodes})
    labels = {scenario: outcomes.labels[scenario] for scenario in scenarios}
    left_out = {(condition.setting, condition.strength) for condition in outcomes.left_out}
    results = ContestedResults(outcomes.results, episodes, left_out)
    return Outcomes(results, labels, outcomes.detectors)


def contested_figures(
    outcomes: Outcomes,
    scenes: Sequence[Scene],
    on_progress: Progress = no_progress,
) -> ContestedFigures | None:
    """Losses, correlation and families where it matters what a car sees.

    Args:
        outcomes: The outcomes of a run.
        scenes: The run's scenes.
        on_progress: Function of the progress, as of `contested_episodes`.

    Returns:
        None where no scenario of the run is contested.
    """
    episodes = contested_episodes(outcomes, scenes, on_progress)
    if not episodes:
        return None
    found = contested_outcomes(outcomes, episodes)
    rates = [
        ContestedRates(
            condition,
            within is found,
            SafetyRates.of(within.records(condition)),
        )
        for condition in found.conditions
        for within in (outcomes, found)
    ]
    return ContestedFigures(
        len(found.scenarios), len(episodes), rates, decoupling(found), family_figures(found)
    )
