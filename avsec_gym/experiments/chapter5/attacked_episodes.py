"""The work of chapter 5: one scene, one detector, one attack, all strengths and intentions."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray

from avsec_gym.attacks.attack import LEFT, RIGHT, Victim, quantised
from avsec_gym.attacks.loss_gradient import total_loss
from avsec_gym.attacks.noise import RandomNoise
from avsec_gym.attacks.patch import PatchAttack
from avsec_gym.attacks.patch_ghosts import ghost_box, target_boxes
from avsec_gym.attacks.patch_placement import PatchPlace
from avsec_gym.attacks.perturbation import Perturbation
from avsec_gym.attacks.texture import replace_texture
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter5.scene_draw import drawn_scenes
from avsec_gym.experiments.chapter5.scenes import OPTIONS, roadside_of, scenes_of
from avsec_gym.experiments.chapter5.settings import (
    DETECTORS,
    GREY_PATCHES,
    JOINT_PATCHES,
    PATCHES,
    STEPS,
    TEXTURE,
    TEXTURE_ATTACKED,
    THESIS_PGD,
    UNATTACKED,
    setting,
    specific,
)
from avsec_gym.experiments.chapter5.stronger_attacks import (
    STRONGER_NAMES,
    STRONGER_OPTIONS,
    chosen_attacks,
    looked_at_steps,
    stronger_iterates,
)
from avsec_gym.experiments.chapter5.trained import patch_file, trained_detector, trained_inputs
from avsec_gym.frame import SensorFrame
from avsec_gym.metrics.ghosts import iou_from_above
from avsec_gym.perception.detectors.detector import DifferentiableDetector
from avsec_gym.perception.stereo_batch import batch_of_frames
from avsec_gym.perception.weights.given import shipped_weights
from avsec_gym.pipeline import Perception, Pipeline, PipelineRun
from avsec_gym.runs.experiment import (
    Cell,
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
_WORK = "avsec_gym.experiments.chapter5.attacked_episodes:AttackedEpisodes"


def attacked_cells(
    configuration: Configuration,
    attacks: Sequence[str],
    detectors: Sequence[str] = DETECTORS,
) -> list[Cell]:
    """A cell for every scene, detector and attack, scene by scene."""
    return [
        Cell.of(_WORK, scene.id, detector=detector, attack=attack, scenario=scene.id)
        for scene in scenes_of(configuration).scenes.scenes
        for detector in detectors
        for attack in attacks
    ]


def stronger_cells(
    configuration: Configuration, detectors: Sequence[str] = DETECTORS
) -> list[Cell]:
    """A cell for every drawn scene, detector and stronger attack that the options name.

    Raises:
        ConfigurationError: There is no such attack, or no such draw or number of steps.
    """
    options = {**STRONGER_OPTIONS, **configuration.options}
    attacks = chosen_attacks(options)
    looked_at_steps(options)  # A slip is reported before anything is done.
    ids = [scene.id for scene in scenes_of(configuration).scenes.labelled]
    drawn = set(drawn_scenes(ids, options["drawn_scenes"], configuration.seed))
    return [
        cell
        for cell in attacked_cells(configuration, attacks, detectors)
        if cell.arguments["scenario"] in drawn
    ]


def attacked_inputs(
    configuration: Configuration, detectors: Sequence[str] = DETECTORS
) -> dict[str, Path]:
    """Weights, patches and the images' manifests.

    Raises:
        ConfigurationError: There is no such motion, or weights are needed that are not named.
        DataError: Weights are missing, or those of another network.
    """
    options = {**OPTIONS, **configuration.options}
    trained = trained_inputs(detectors, options)
    if Motion.named(options["motion"]) == Motion.CLASSIFIER:
        trained["weights of the moving-object classifier"] = shipped_weights("motion_small")
    roots = {data.root for data in scenes_of(configuration).data.values()}
    manifests = {
        f"frames {number}": root / "manifest.json"
        for number, root in enumerate(sorted(roots), start=1)
        if (root / "manifest.json").is_file()
    }
    return {**trained, **manifests}


@dataclass(frozen=True, eq=False)
class _Look:
    """A frame that the car is shown, and the settings of its results."""

    frame: SensorFrame
    attack: str
    strength: float = 0.0
    intentions: tuple[Intention, ...] = tuple(Intention)
    """The intentions of the episodes that follow."""
    seen_as: str = ""
    """Attack in the setting of detections, if it is not `attack`: a specific one has intentions."""
    place: PatchPlace | None = None
    """Place of a patch."""
    ghost_width: float | None = None
    """Width of the ghosts that the patch was trained towards, see `ghost_box`."""
    whole_levels: bool = False
    attacked: SensorFrame | None = None
    """The frame that the attack began with; None: the clean one."""


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
            attack: See `avsec_gym.experiments.chapter5.settings`.
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
                    _measure(result, look, scene, clean, victim, believed, losses=sheet)

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
    ) -> Iterator[_Look]:
        seed = (self._seed, scene.number)
        kind, _, rest = attack.partition("-")
        if attack == UNATTACKED:
            yield _Look(clean, attack)
        elif kind == THESIS_PGD:
            yield from _perturbed(attack, float(rest), clean, victim)
        elif kind == "noise":
            noisy = RandomNoise(STEPS * float(rest)).attack(clean, victim, seed)
            yield _Look(noisy, attack, STEPS)
        elif attack == TEXTURE:
            changed = replace_texture(clean, roadside_of(self._scenes, scene), seed)
            yield _Look(changed, attack)
            yield from _perturbed(TEXTURE_ATTACKED, 1.0, changed, victim)
        elif attack in PATCHES + JOINT_PATCHES + GREY_PATCHES:
            patch = PatchAttack(self._patch(kind, victim.detector.name), rest)  # type: ignore[arg-type]
            yield from _patched(attack, patch, clean, victim, seed)
        elif attack in STRONGER_NAMES:
            for n, frame in stronger_iterates(attack, clean, victim, self._options, seed):
                yield _Look(frame, attack, n)
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


def _perturbed(attack: str, alpha: float, before: SensorFrame, victim: Victim) -> Iterator[_Look]:
    """Every n, as the attack leaves the pixels, and as a camera would deliver them."""
    iterates = Perturbation(alpha, steps=STEPS).iterates(before, victim)
    for n, frame in enumerate(iterates, start=1):
        yield _Look(frame, attack, n, attacked=before)
        if not alpha.is_integer():  # Steps of whole levels leave nothing to round.
            yield _Look(quantised(frame), attack, n, whole_levels=True)


def _patched(
    attack: str, patch: PatchAttack, clean: SensorFrame, victim: Victim, seed: tuple[int, int]
) -> Iterator[_Look]:
    """One look for all intentions, or for each its own; a printed patch has whole levels anyway."""
    if patch.placement == "random":
        place = patch.placed(clean, victim, seed)
        frame = quantised(patch.attack(clean, victim, seed))
        yield _Look(frame, attack, place=place, ghost_width=patch.ghost_width)
        return
    for number, intention in enumerate(Intention):
        aimed = replace(victim, intention=intention)
        place = patch.placed(clean, aimed, (*seed, number))
        frame = quantised(patch.attack(clean, aimed, (*seed, number)))
        yield _Look(
            frame,
            attack,
            intentions=(intention,),
            seen_as=specific(attack, intention),
            place=place,
            ghost_width=patch.ghost_width,
        )


def _take(result: _Result, look: _Look, scene: Scene, pipeline: Pipeline) -> Boxes3D:
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


def _measure(
    result: _Result,
    look: _Look,
    scene: Scene,
    clean: SensorFrame,
    victim: Victim,
    believed: Boxes3D,
    *,
    losses: bool,
) -> None:
    """Add the largest change of a grey level, a patch's place, and the losses that it aims at.

    ``loss`` is that to the truth, which perturbations raise; ``ghost_loss`` that to b*, which a
    patch lowers, from ``clean_ghost_loss``, measured where it is placed at random; ``ghost_seen``
    is 1 where the planner gets a box that meets the patch's ghost on the ground.
    """
    before = clean if look.attacked is None else look.attacked
    changes = [
        np.abs(np.subtract(look.frame.image(camera), before.image(camera), dtype=float)).max()
        for camera in (LEFT, RIGHT)
    ]
    numbers = {"change": float(max(changes))}
    detector = victim.detector if losses else None
    if look.place is None:
        if isinstance(detector, DifferentiableDetector):
            numbers["loss"] = _loss(detector, look.frame, victim.truth, victim.disparity)
    else:
        aim = look.place.intention(clean.image(LEFT).shape[1])
        numbers["attack_intention"] = list(Intention).index(aim)
        ghost = ghost_box(look.place, clean.calibration, look.ghost_width)
        overlap = iou_from_above(believed, ghost)
        numbers["ghost_seen"] = float((overlap > 0).any())
        if not look.seen_as and isinstance(detector, DifferentiableDetector):
            ghosts = target_boxes(look.place, clean.calibration, victim.truth, look.ghost_width)
            numbers["clean_ghost_loss"] = _loss(detector, clean, ghosts)
            numbers["ghost_loss"] = _loss(detector, look.frame, ghosts)
    filed = setting(victim.detector.name, look.seen_as or look.attack)
    for name, value in numbers.items():
        result.measurements.append(Measurement(filed, scene.id, name, value, look.strength))


def _loss(
    detector: DifferentiableDetector,
    frame: SensorFrame,
    boxes: Boxes3D,
    disparity: NDArray[np.float32] | None = None,
) -> float:
    known = None if disparity is None else torch.from_numpy(disparity)[None]
    with torch.no_grad():
        return float(total_loss(detector, batch_of_frames([frame]), [boxes], known))
