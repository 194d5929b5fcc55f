"""A run's results with the episodes of another planner in place of its own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter5.outcomes import Condition, Outcomes
from avsec_gym.metrics.safety import SafetyRecord
from avsec_gym.planners.planner import Algorithm
from avsec_gym.runs.experiment import Measurement
from avsec_gym.runs.results import Results


@dataclass(frozen=True, eq=False)
class ReplannedResults:
    """Detections and measurements of a run, and other episodes; see `Results`.

    Args:
        results: The results of the run.
        episodes: Records by setting and strength; there are no others.
        planner: The planner whose episodes they are.
    """

    results: Results
    episodes: Mapping[tuple[str, float], Sequence[SafetyRecord]]
    planner: Algorithm

    def settings(self) -> list[tuple[str, float]]:
        """See `Results`."""
        return self.results.settings()

    def records(self, **where: Any) -> list[SafetyRecord]:
        """See `Results`; by setting, strength, planner and intention."""
        found = [
            record
            for (setting, strength), records in self.episodes.items()
            if where.get("setting", setting) == setting
            and where.get("strength", strength) == strength
            and where.get("planner", self.planner) == self.planner
            for record in records
            if where.get("intention", record.intention) == record.intention
        ]
        return sorted(found, key=lambda record: (record.scenario, record.intention))

    def detections(self, setting: str, strength: float = 0.0) -> dict[str, Boxes3D]:
        """See `Results`."""
        return self.results.detections(setting, strength)

    def measurements(self, **where: Any) -> list[Measurement]:
        """See `Results`."""
        return self.results.measurements(**where)


def replanned(
    outcomes: Outcomes, records: Mapping[Condition, Sequence[SafetyRecord]], planner: Algorithm
) -> Outcomes:
    """The outcomes of the same detections with another planner's episodes.

    Args:
        outcomes: The outcomes of a run.
        records: The episodes of each condition, on the run's scenarios; other conditions have none.
        planner: The planner.
    """
    episodes = {(each.setting, each.strength): found for each, found in records.items()}
    labels = {scenario: outcomes.labels[scenario] for scenario in outcomes.scenarios}
    results = ReplannedResults(outcomes.results, episodes, planner)
    return Outcomes(results, labels, outcomes.detectors)
