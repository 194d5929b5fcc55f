"""Any parts of the pipeline under any attack, those of plug-ins too: how safe are the episodes?

    avsec run pipeline --options detector=dsgn planner=mine attack='{"name": "mine", "size": 2}'

Every scene has episodes to the left, straight and to the right on the ground truth, on what the
detector sees, and on what it sees under the attack; a validator may stand before it.
"""

from __future__ import annotations

from avsec_gym.attacks.attacked_detector import attack_kind
from avsec_gym.experiments.chapter5.scenes import scenes_of
from avsec_gym.experiments.chapter5.settings import Options
from avsec_gym.experiments.procedural_frames import PROCEDURAL, USUAL_COUNT
from avsec_gym.pipeline import Pipeline, run_episode
from avsec_gym.registry import Kind, check
from avsec_gym.runs.experiment import (
    Cell,
    CellResult,
    Configuration,
    DetectionRow,
    EpisodeRow,
    Experiment,
)
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Motion
from avsec_gym.validation.response import Response

OPTIONS: Options = {
    "detector": {"name": "dsgn"},
    "attack": None,
    "planner": {"name": "astar"},
    "validator": None,
    "response": "stop",
    "classifier": None,
    "selector": None,
    "motion": "truth",
    "score_threshold": 0.3,
}
"""Options as of `avsec_gym.pipeline.Pipeline`; parts by name, or as JSON of a name and
arguments."""
TRUTH, UNATTACKED, ATTACKED = "pipeline truth", "pipeline unattacked", "pipeline attacked"
"""The settings of episodes."""

_WORK = "avsec_gym.experiments.pipeline_episodes:PipelineEpisodes"


def _cells(configuration: Configuration) -> list[Cell]:
    """A cell for every scene.

    Raises:
        ConfigurationError: There is no part of one of the names, or it has no such arguments.
    """
    options = {**OPTIONS, **configuration.options}
    # The parts first: a slip is reported before minutes in which scenes are rendered.
    for kind in Kind:
        if (part := options.get(kind)) is not None:
            check(attack_kind(part) if kind == Kind.ATTACK else kind, part)
    Motion.named(options["motion"])
    Response.named(options["response"])
    scenes = scenes_of(configuration).scenes.scenes
    return [Cell.of(_WORK, scene.id, scenario=scene.id) for scene in scenes]


class PipelineEpisodes:
    """Attacks, perceives and plans; see `avsec_gym.runs.experiment.Work`.

    Args:
        configuration: The configuration of the run.

    Raises:
        ConfigurationError: There is no part of one of the names.
    """

    def __init__(self, configuration: Configuration) -> None:
        options = {**OPTIONS, **configuration.options}
        self._seed = configuration.seed
        self._scenes = scenes_of(configuration)
        self._by_id = {scene.id: scene for scene in self._scenes.scenes.labelled}
        self._pipeline = Pipeline(**options)
        planner = options["planner"]
        self._planner = planner if isinstance(planner, str) else str(planner["name"])

    def __call__(self, scenario: str) -> CellResult:
        """The results of one cell.

        Args:
            scenario: The scene's id.

        Raises:
            DataError: A file is missing or broken.
        """
        scene, pipeline = self._by_id[scenario], self._pipeline
        clean = self._scenes.frame(scene)
        episodes: list[EpisodeRow] = []
        for way in Intention:
            truth = run_episode(scene, way, motion=Motion.TRUTH, planner=pipeline.planner)
            episodes.append(EpisodeRow(TRUTH, truth.record, planner=self._planner))
        looks = {UNATTACKED: clean}
        if pipeline.attack is not None:
            disparity = self._scenes.disparity(scene)
            seed = (self._seed, scene.number)
            looks[ATTACKED] = pipeline.tampered(scene, clean, seed=seed, disparity=disparity)
        detections = []
        for setting, frame in looks.items():
            perception = pipeline.perceive(frame)
            detections.append(DetectionRow(setting, scenario, perception.detections))
            for way in Intention:
                episode = pipeline.run_episode(scene, perception, way)
                episodes.append(EpisodeRow(setting, episode.record, planner=self._planner))
        return CellResult(episodes, detections)


PIPELINE = Experiment(
    "pipeline",
    "What becomes of the episodes with these parts, under this attack?",
    "",
    _cells,
    options=OPTIONS,
    usual=Configuration(PROCEDURAL, USUAL_COUNT),
)
