"""Episodes on the ground truth, by both searches: what no detector can be blamed for."""

from __future__ import annotations

import time
from pathlib import Path

from avsec_gym.experiments.chapter5.scenes import scenes_of
from avsec_gym.pipeline import run_episode
from avsec_gym.planners.planner import Algorithm, MotionPrimitivePlanner
from avsec_gym.runs.experiment import Cell, CellResult, Configuration, EpisodeRow
from avsec_gym.scenario.intention import Intention

GROUND_TRUTH = "ground_truth"
"""What the episodes are filed under."""

_WORK = "avsec_gym.experiments.chapter5.true_episodes:TrueEpisodes"


def true_cells(configuration: Configuration) -> list[Cell]:
    """A cell for every scene."""
    scenes = scenes_of(configuration).scenes.scenes
    return [Cell.of(_WORK, scene.id, scenario=scene.id) for scene in scenes]


def true_inputs(configuration: Configuration) -> dict[str, Path]:
    """Nothing but the labels, which the configuration names."""
    return {}


class TrueEpisodes:
    """The planner knows everything; see `avsec_gym.runs.experiment.Work`.

    Args:
        configuration: The configuration of the run.
    """

    def __init__(self, configuration: Configuration) -> None:
        self._by_id = {scene.id: scene for scene in scenes_of(configuration).scenes.labelled}
        self._planners = {str(name): MotionPrimitivePlanner(name) for name in Algorithm}

    def __call__(self, scenario: str) -> CellResult:
        """The results of one cell.

        Args:
            scenario: The scene's id.
        """
        start = time.perf_counter()
        rows = [
            EpisodeRow(
                GROUND_TRUTH,
                run_episode(self._by_id[scenario], intention, planner=planner).record,
                planner=name,
            )
            for name, planner in self._planners.items()
            for intention in Intention
        ]
        return CellResult(episodes=rows, seconds={"planner": time.perf_counter() - start})
