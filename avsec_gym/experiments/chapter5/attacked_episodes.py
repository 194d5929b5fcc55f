"""The work of chapter 5: one scene, one detector, one attack, all strengths and intentions."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from avsec_gym.attacks.attack import Victim
from avsec_gym.attacks.noise import RandomNoise
from avsec_gym.attacks.patch import PatchAttack
from avsec_gym.attacks.texture import replace_texture
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter5.look_measurements import look_measurements
from avsec_gym.experiments.chapter5.looks import CellLook, patched_looks, perturbed_looks
from avsec_gym.experiments.chapter5.scenes import OPTIONS, roadside_of, scenes_of
from avsec_gym.experiments.chapter5.settings import (
    GREY_PATCHES,
    JOINT_PATCHES,
    PATCHES,
    STEPS,
    TEXTURE,
    TEXTURE_ATTACKED,
    THESIS_PGD,
    UNATTACKED,
    setting,
)
from avsec_gym.experiments.chapter5.stronger_attacks import (
    STRONGER_NAMES,
    STRONGER_OPTIONS,
    stronger_iterates,
)
from avsec_gym.experiments.chapter5.trained import patch_file, trained_detector
from avsec_gym.frame import SensorFrame
from avsec_gym.pipeline import Perception, Pipeline, PipelineRun
from avsec_gym.runs.experiment import (
    CellResult,
    Configuration,
    DetectionRow,
    EpisodeRow,
    Measurement,
)
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Motion, Scene

CLASSIFIER = "small"
"""The moving-object classifier of ``motion=classifier``, with the package's weights."""


@dataclass(frozen=True, eq=False)
class _Result:
    """The results so far."""

    episodes: list[EpisodeRow] = field(default_factory=list)
    detections: list[DetectionRow] = field(default_factory=list)
    measurements: list[Measurement] = field(default_factory=list)
    seconds: dict[str, float] = field(default_factory=dict)

    @contextmanager
    def timed(self, part: str) -> Iterator[None]:
        start = time.perf_counter()
        yield
        self.seconds[part] = self.seconds.get(part, 0.0) + time.perf_counter() - start


class AttackedEpisodes:
    """Attacks, perceives and plans; see `avsec_gym.runs.experiment.Work`.

    Args:
        configuration: The configuration of the run.
    """

    def __init__(self, configuration: Configuration) -> None:
        self._options = {**OPTIONS, **STRONGER_OPTIONS, **configuration.options}
        self._seed = configuration.seed
        self._scenes = scenes_of(configuration)
        self._by_id = {scene.id: scene for scene in self._scenes.scenes.labelled}
        self._pipelines: dict[str, Pipeline] = {}

    def __call__(self, detector: str, attack: str, scenario: str) -> CellResult:
        """The results of one cell.

        Args:
            detector: The detector's name.
            attack: The attack, see `avsec_gym.experiments.chapter5.settings`.
            scenario: The scene's id.

        Raises:
            ConfigurationError: There is no such attack.
            DataError: A file is missing or broken.
        """
        scene, pipeline, clean, victim = self._situation(detector, scenario)
        result = _Result()
        looks = self._looks(attack, scene, clean, victim)
        sheet = self._options["sanity_sheet"]
        while True:
            with result.timed("attack"):
                look = next(looks, None)
            if look is None:
                return CellResult(
                    result.episodes, result.detections, result.measurements, result.seconds
                )
            if look.whole_levels and not sheet:
                continue
            believed = _take(result, look, scene, pipeline)
            last = look.strength in (0, STEPS) or attack in STRONGER_NAMES
            if last and not look.whole_levels:
                with result.timed("measuring"):
                    result.measurements.extend(
                        look_measurements(look, scene, clean, victim, believed, losses=sheet)
                    )

    def again(
        self,
        detector: str,
        attack: str,
        scenario: str,
        intention: Intention,
        strength: float = 0.0,
        *,
        whole_levels: bool = False,
    ) -> PipelineRun:
        """One episode of a run once more, for a picture: with what the car saw and believed.

        Args:
            detector: The detector's name.
            attack: The attack in the episode's setting, such as ``texture-thesis_pgd-1``.
            scenario: The scene's id.
            intention: The driving intention.
            strength: The strength of the attack.
            whole_levels: Whether attacked pixels were rounded.

        Raises:
            ConfigurationError: There is no such episode.
            DataError: A file is missing or broken.
        """
        scene, pipeline, clean, victim = self._situation(detector, scenario)
        whole_cell = TEXTURE if attack.startswith(TEXTURE) else attack
        wanted = (attack, strength, whole_levels)
        for look in self._looks(whole_cell, scene, clean, victim):
            found = (look.attack, look.strength, look.whole_levels)
            if found == wanted and intention in look.intentions:
                perception = pipeline.perceive(look.frame)
                episode = pipeline.run_episode(scene, perception, intention)
                return PipelineRun(look.frame, perception, episode, perception.seconds)
        raise ConfigurationError(f"{attack} has no episode of strength {strength:g}")

    def _looks(
        self, attack: str, scene: Scene, clean: SensorFrame, victim: Victim
    ) -> Iterator[CellLook]:
        seed = (self._seed, scene.number)
        kind, _, rest = attack.partition("-")
        if attack == UNATTACKED:
            yield CellLook(clean, attack)
        elif kind == THESIS_PGD:
            yield from perturbed_looks(attack, float(rest), clean, victim)
        elif kind == "noise":
            noisy = RandomNoise(STEPS * float(rest)).attack(clean, victim, seed)
            yield CellLook(noisy, attack, STEPS)
        elif attack == TEXTURE:
            changed = replace_texture(clean, roadside_of(self._scenes, scene), seed)
            yield CellLook(changed, attack)
            yield from perturbed_looks(TEXTURE_ATTACKED, 1.0, changed, victim)
        elif attack in PATCHES + JOINT_PATCHES + GREY_PATCHES:
            patch = PatchAttack(self._patch(kind, victim.detector.name), rest)  # type: ignore[arg-type]
            yield from patched_looks(attack, patch, clean, victim, seed)
        elif attack in STRONGER_NAMES:
            for n, frame in stronger_iterates(attack, clean, victim, self._options, seed):
                yield CellLook(frame, attack, n)
        else:
            raise ConfigurationError(f"chapter 5 has no attack {attack!r}")

    def _situation(
        self, detector: str, scenario: str
    ) -> tuple[Scene, Pipeline, SensorFrame, Victim]:
        scene, pipeline = self._by_id[scenario], self._pipeline(detector)
        victim = Victim(pipeline.detector, scene.boxes, None, self._scenes.disparity(scene))
        return scene, pipeline, self._scenes.frame(scene), victim

    def _patch(self, kind: str, detector: str) -> str | Path:
        if kind == "grey":
            return kind
        return patch_file(kind, detector, self._options)

    def _pipeline(self, detector: str) -> Pipeline:
        if detector not in self._pipelines:
            motion = Motion.named(self._options["motion"])
            self._pipelines[detector] = Pipeline(
                trained_detector(detector, self._options),
                classifier=CLASSIFIER if motion == Motion.CLASSIFIER else None,
                motion=motion,
                score_threshold=self._options["score_threshold"],
                whole_levels=False,
            )
        return self._pipelines[detector]


def _take(result: _Result, look: CellLook, scene: Scene, pipeline: Pipeline) -> Boxes3D:
    """Add detections, and the episodes that follow; returns the boxes that are planned on."""
    name = pipeline.detector.name
    with result.timed("detector"):
        perception = pipeline.perceive(look.frame)
    seen = setting(name, look.seen_as or look.attack, whole_levels=look.whole_levels)
    boxes = with_known_motion(perception, pipeline.score_threshold)
    result.detections.append(DetectionRow(seen, scene.id, boxes, look.strength))
    under = setting(name, look.attack, whole_levels=look.whole_levels)
    with result.timed("planner"):
        for intention in look.intentions:
            record = pipeline.run_episode(scene, perception, intention).record
            result.episodes.append(EpisodeRow(under, record, look.strength))
    return perception.believed


def with_known_motion(perception: Perception, threshold: float) -> Boxes3D:
    """All detections, `moving` where a classifier takes them as moving, to be planned on anew.

    Args:
        perception: What the car believes.
        threshold: The least score of a detection that is planned on: the classifier looks at no
            other, and the others stand.
    """
    detections, flags = perception.detections, perception.believed.moving
    if flags is None:
        return detections
    moving = np.zeros(len(detections), bool)
    moving[detections.score >= threshold] = flags
    return replace(detections, moving=moving)
