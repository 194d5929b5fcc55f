"""An experiment of a few cells that end at once, for the files of a run; workers import it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.pipeline import run_episode
from avsec_gym.runs.experiment import (
    Cell,
    CellResult,
    Configuration,
    DetectionRow,
    EpisodeRow,
    Experiment,
    Measurement,
)
from avsec_gym.scenario.scene_sets import procedural_scenes

if TYPE_CHECKING:
    from avsec_gym.runs.run import RunSummary

SETTINGS = ("tiny", "tiny+attack")
CONFIGURATION = Configuration(seed=1)


class Work:
    """Drives one scene."""

    def __init__(self, configuration: Configuration) -> None:
        self._scenes = procedural_scenes(4, seed=configuration.seed).labelled

    def __call__(self, number: int) -> CellResult:
        """Rows of every table."""
        scene = self._scenes[number]
        record = run_episode(scene, "left").record
        boxes: Boxes3D = scene.boxes
        return CellResult(
            episodes=[EpisodeRow(setting, record) for setting in SETTINGS],
            detections=[DetectionRow(setting, scene.id, boxes) for setting in SETTINGS],
            measurements=[Measurement(SETTINGS[0], scene.id, "loss", float(np.log1p(number)))],
            seconds={"planning": 0.01},
        )


EXPERIMENT = Experiment(
    "tiny",
    "Is a damaged file of a run recognised?",
    "",
    lambda configuration: [Cell.of("tiny_run:Work", number=number) for number in range(4)],
)


def make(folder: Path) -> RunSummary:
    """Do what is missing of the run in a folder; in this very process."""
    from avsec_gym.runs.run import run_experiments

    return run_experiments([EXPERIMENT], CONFIGURATION, folder, workers=0, threads=1)


def look(folder: Path) -> object:
    """Read all of a run, then go on with it."""
    from avsec_gym.commands.report import Report
    from avsec_gym.runs.run_folder import RunFolder

    run = RunFolder.open(folder)
    seen: list[object] = [run.configuration, run.experiments, run.cells(), run.failures()]
    seen += [run.missing(), run.timings(), run.measurements()]
    for setting, strength in run.settings():
        seen.append(run.records(setting=setting, strength=strength))
        seen.append(run.detections(setting, strength))
    # The page of the run: what it is made with is in the manifest, too.
    Report(folder, pictures=0).written(quietly=True)
    report = make(folder)
    assert report.done + report.kept == 4, "a resumed run has all of its cells"
    return seen
