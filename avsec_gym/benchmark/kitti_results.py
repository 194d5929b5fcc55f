"""Results of a detector on KITTI's own frames: driven by in the labelled scenarios, and scored.

Its files were made from images that no attack has touched, so there is one setting beside the
truth.  The car plans on its boxes as in the rest of the benchmark: a box moves as the true object
that it overlaps most.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from avsec_gym.benchmark.entry import EntryRow
from avsec_gym.benchmark.episodes import ENTERED
from avsec_gym.benchmark.kitti_scenes import KITTI, frozen_labels
from avsec_gym.benchmark.protocol import TRUTH, UNATTACKED
from avsec_gym.benchmark.query_rows import moderate_precision, share_of_episodes
from avsec_gym.boxes import Boxes3D
from avsec_gym.emergency_stop import STOPPED
from avsec_gym.errors import DataError
from avsec_gym.evaluation.rates import Detected
from avsec_gym.kitti.detections import DetectionFolder
from avsec_gym.metrics.paired import paired_differences
from avsec_gym.metrics.safety import SafetyRates, SafetyRecord
from avsec_gym.pipeline import run_episode
from avsec_gym.runs.experiment import (
    Cell,
    CellResult,
    Configuration,
    DetectionRow,
    EpisodeRow,
    Experiment,
)
from avsec_gym.runs.results import Results
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene_set import SceneSet

OPTIONS = {"labels": "", "detections": ""}
"""The user's folders of the labelled scenarios, and of the detector's result files."""
_WORK = f"{__name__}:KittiEpisodes"
_SETTINGS = (TRUTH, UNATTACKED)


def check_kitti(labels: Path, detections: Path) -> None:
    """Refuse other labels than the frozen ones, and results that are not there for every frame.

    Args:
        labels: The folder of the labelled scenarios.
        detections: The detector's folder of KITTI result files.

    Raises:
        DataError: As above; a file in which nothing was found is empty.
    """
    ids = [scene.id for scene in frozen_labels().scenes(labels).labelled]
    folder = DetectionFolder(detections)
    there = {*folder.ids()}
    missing = [id for id in ids if id not in there]
    if missing:
        raise DataError(
            f"{len(missing)} of {len(ids)} result files are not here, the first {missing[0]}.txt.",
            path=folder.folder,
            remedy="Write a file for every frame, an empty one where nothing was found.",
        )


def kitti_rows(run: Results, labels: Path) -> list[EntryRow]:
    """The rows of an entry: all scenes, and the contested ones.

    Args:
        run: A run of `BENCHMARK_KITTI`.
        labels: The folder of the labelled scenarios.
    """
    frozen = frozen_labels()
    every, truth = frozen.scenes(labels), frozen.truth(labels)
    return [*_rows(run, every, truth), *_rows(run, frozen.of_contested(every), truth)]


def _rows(run: Results, scenes: SceneSet, truth: Mapping[str, Boxes3D]) -> list[EntryRow]:
    """The rows of one set of scenes: with the truth, and with the detections."""
    by_setting = {setting: _played(run, scenes, setting) for setting in _SETTINGS}
    ids = {scene.id for scene in scenes.scenes}
    found = {id: boxes for id, boxes in run.detections(UNATTACKED).items() if id in ids}
    rows = []
    for setting, records in by_setting.items():
        detected = setting == UNATTACKED
        rows.append(
            EntryRow(
                scenes=scenes.name,
                setting=setting,
                rates=SafetyRates.of(records),
                precision=moderate_precision(found, truth) if detected and found else None,
                against=TRUTH if detected else "",
                paired=paired_differences(by_setting[TRUTH], records) if detected else None,
                collided=share_of_episodes(records, [each.collision for each in records]),
                stopped=share_of_episodes(records, [each.reason == STOPPED for each in records]),
            )
        )
    return rows


def _played(run: Results, scenes: SceneSet, setting: str) -> list[SafetyRecord]:
    """The episodes of those scenes and intentions that count."""
    ids = {scene.id for scene in scenes.scenes}
    return [
        record
        for record in run.records(setting=setting, planner=ENTERED)
        if record.scenario in ids and scenes.plays(record.scenario, Intention(record.intention))
    ]


def _cells(configuration: Configuration) -> list[Cell]:
    """A cell for every scene."""
    scenes = frozen_labels().scenes(Path(configuration.options["labels"]))
    return [Cell.of(_WORK, scene.id, scenario=scene.id) for scene in scenes.labelled]


def _inputs(configuration: Configuration) -> dict[str, Path]:
    return {name: Path(configuration.options[name]) for name in OPTIONS}


class KittiEpisodes:
    """Drives a labelled scene by the truth and by a detector's boxes; see `Work`.

    Args:
        configuration: The configuration of the run.

    Raises:
        DataError: Labels are not the frozen ones, or a file is broken.
    """

    def __init__(self, configuration: Configuration) -> None:
        options = configuration.options
        scenes = frozen_labels().scenes(Path(options["labels"])).labelled
        self._scenes = {scene.id: scene for scene in scenes}
        boxes, _ = DetectionFolder(options["detections"]).read(self._scenes)
        self._found, self._kept = boxes, Detected(boxes).kept()

    def __call__(self, scenario: str) -> CellResult:
        """The results of one cell.

        Args:
            scenario: The scene's id.
        """
        scene = self._scenes[scenario]
        believed = {TRUTH: None, UNATTACKED: self._kept[scenario]}
        episodes = [
            EpisodeRow(setting, run_episode(scene, way, boxes).record, planner=ENTERED)
            for setting, boxes in believed.items()
            for way in Intention
        ]
        return CellResult(episodes, [DetectionRow(UNATTACKED, scenario, self._found[scenario])])


BENCHMARK_KITTI = Experiment(
    "benchmark_kitti",
    "How safely does a car drive by this detector's results on KITTI?",
    "",
    _cells,
    inputs=_inputs,
    options=OPTIONS,
    usual=Configuration(KITTI),
)
