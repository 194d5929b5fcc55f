"""Does what the protocol asks for: an experiment whose cells are the scenes of one frozen set."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from avsec_gym.benchmark.protocol import Entered, Setting, places_in, settings_of
from avsec_gym.benchmark.scene_sets import frozen_sets
from avsec_gym.metrics.safety import SafetyRecord
from avsec_gym.perception import weights
from avsec_gym.pipeline import Perception, Pipeline, run_episode
from avsec_gym.registry import Kind, make
from avsec_gym.runs.experiment import (
    Cell,
    CellResult,
    Configuration,
    DetectionRow,
    EpisodeRow,
    Experiment,
    Measurement,
)
from avsec_gym.scenario.frame_scenes import FrameScenes
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Scene
from avsec_gym.scenario.scene_set import SceneSet

ALARM, NAMED = "alarm", "named"
"""Measurements of validators: whether there was an alarm, and whether it named the sensors that
were attacked, no more and no fewer."""
OPTIONS = {"kind": "detector", "part": {"name": "dsgn"}, "quick": False, "world": ""}
"""What is entered, the part, whether only the scenes of a quick entry are used, and the fingerprint
of the world that rendered them: a run does not go on with another one."""

_WORK = "avsec_gym.benchmark.episodes:BenchmarkEpisodes"


def _scenes(configuration: Configuration) -> FrameScenes | SceneSet:
    """The scenes of one frozen set, `configuration.scenarios`; with frames where these are seen."""
    frozen = frozen_sets()[configuration.scenarios]
    quick = bool(configuration.options["quick"])
    if Entered(configuration.options["kind"]).sees:
        return frozen.frames(quick=quick)
    return frozen.layouts(quick=quick)


def _set_of(scenes: FrameScenes | SceneSet) -> SceneSet:
    return scenes.scenes if isinstance(scenes, FrameScenes) else scenes


def _settings(configuration: Configuration) -> list[Setting]:
    options = configuration.options
    return settings_of(Entered(options["kind"]), options["part"], configuration.scenarios)


def _cells(configuration: Configuration) -> list[Cell]:
    """A cell for every scene.

    Raises:
        ConfigurationError: There is no such part.
        DataError: A folder of results is missing.
    """
    _settings(configuration)  # A slip is reported before minutes in which scenes are rendered.
    scenes = _set_of(_scenes(configuration)).labelled
    return [Cell.of(_WORK, scene.id, scenario=scene.id) for scene in scenes]


def _inputs(configuration: Configuration) -> dict[str, Path]:
    """What a run does not go on without, or with other content: weights, fits, patches, results."""
    inputs: dict[str, Path] = {}
    for setting in _settings(configuration):
        inputs |= places_in(setting.parts or {}) | places_in(setting.planner)
    if Entered(configuration.options["kind"]).sees:
        inputs["weights"] = Path(weights.__file__).parent
    return inputs


class BenchmarkEpisodes:
    """Drives a scene under every setting; see `avsec_gym.runs.experiment.Work`.

    Args:
        configuration: The configuration of the run.

    Raises:
        ConfigurationError: There is no such part.
    """

    def __init__(self, configuration: Configuration) -> None:
        self._seed = configuration.seed
        self._scenes = _scenes(configuration)
        self._set = _set_of(self._scenes)
        self._by_id = {scene.id: scene for scene in self._set.labelled}
        # One network for all settings that have it.
        made: dict[str, Any] = {}
        self._settings = [
            (setting, _pipeline(setting, made)) for setting in _settings(configuration)
        ]

    def __call__(self, scenario: str) -> CellResult:
        """The results of one cell.

        Args:
            scenario: The scene's id.

        Raises:
            DataError: A file is missing or broken.
        """
        scene = self._by_id[scenario]
        ways = [way for way in Intention if self._set.plays(scenario, way)]
        drives: list[EpisodeRow] = []
        detections: list[DetectionRow] = []
        measurements: list[Measurement] = []
        for setting, pipeline in self._settings:
            if isinstance(pipeline, Pipeline):
                found, measured, rows = self._seen(setting, pipeline, scene, ways)
                detections.append(found)
                measurements += measured
                drives += rows
            else:
                for way in ways:
                    episode = run_episode(scene, way, planner=pipeline)
                    drives.append(EpisodeRow(setting.name, episode.record, planner=ENTERED))
        return CellResult(drives, detections, measurements)

    def _seen(
        self, setting: Setting, pipeline: Pipeline, scene: Scene, ways: list[Intention]
    ) -> tuple[DetectionRow, list[Measurement], list[EpisodeRow]]:
        """One scene, perceived under one setting, and driven through."""
        perception, records = self._driven(pipeline, scene, ways, ())
        # An attacker who knows the validator goes on until all episodes collide without an alarm.
        for number, attack in enumerate(setting.attempts, start=1):
            if _quiet_collisions(perception, records) == len(ways):
                break
            other = self._driven(replace(pipeline, attack=attack), scene, ways, (number,))
            if _quiet_collisions(*other) > _quiet_collisions(perception, records):
                perception, records = other
        measured = []
        if (validation := perception.validation) is not None:
            attacked = frozenset() if pipeline.attack is None else pipeline.attack.sensors
            for name, value in (
                (ALARM, validation.alarm),
                (NAMED, validation.attacked == attacked),
            ):
                measured.append(Measurement(setting.name, scene.id, name, float(value)))
        drives = [EpisodeRow(setting.name, record, planner=ENTERED) for record in records]
        return DetectionRow(setting.name, scene.id, perception.detections), measured, drives

    def _driven(
        self, pipeline: Pipeline, scene: Scene, ways: list[Intention], attempt: tuple[int, ...]
    ) -> tuple[Perception, list[SafetyRecord]]:
        """What the car believes in a scene, and what becomes of its episodes."""
        assert isinstance(self._scenes, FrameScenes)
        frame = pipeline.tampered(
            scene,
            self._scenes.frame(scene),
            seed=(self._seed, scene.number, *attempt),
            disparity=self._scenes.disparity(scene),
        )
        perception = pipeline.perceive(frame)
        return perception, [pipeline.run_episode(scene, perception, way).record for way in ways]


def _quiet_collisions(perception: Perception, records: list[SafetyRecord]) -> int:
    """Episodes that collide while the validator is silent."""
    validation = perception.validation
    silent = validation is None or not validation.alarm
    return sum(record.collision for record in records) if silent else 0


ENTERED = "entered"
"""What the rows of a run call the planner: an entry has one."""


def _pipeline(setting: Setting, made: dict[str, Any]) -> Any:
    """The pipeline of a setting; the planner alone where the truth is planned on."""
    if setting.parts is None:
        return make(Kind.PLANNER, setting.planner)
    parts = dict(setting.parts)
    key = repr(parts["detector"])
    if key not in made:
        made[key] = make(Kind.DETECTOR, parts["detector"])
    return Pipeline(**{**parts, "detector": made[key]})


BENCHMARK = Experiment(
    "benchmark",
    "How good is this part of the pipeline, all else being as frozen?",
    "",
    _cells,
    inputs=_inputs,
    options=OPTIONS,
    usual=Configuration("all"),
)
