"""The work behind chapter 5: one scene, one detector, one attack, all strengths and intentions."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import torch

from avsec_gym import attacks
from avsec_gym.attacks.attack import LEFT, RIGHT, Victim, quantised
from avsec_gym.attacks.loss_gradient import total_loss
from avsec_gym.attacks.noise import RandomNoise
from avsec_gym.attacks.patch import PatchAttack
from avsec_gym.attacks.perturbation import Perturbation
from avsec_gym.attacks.side_area import read_roadside
from avsec_gym.attacks.texture import replace_texture
from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter5.settings import (
    DETECTORS,
    GREY_PATCHES,
    JOINT_PATCHES,
    PATCHES,
    STEPS,
    TEXTURE,
    UNATTACKED,
    setting,
    specific,
)
from avsec_gym.experiments.experiment import (
    Cell,
    CellResult,
    Configuration,
    DetectionRow,
    DriveRow,
    Measurement,
)
from avsec_gym.frame import SensorFrame
from avsec_gym.perception.detectors.detector import DifferentiableDetector
from avsec_gym.perception.stereo_batch import batch_of_frames
from avsec_gym.perception.weights.given import shipped_weights
from avsec_gym.pipeline import Pipeline
from avsec_gym.scenario.frame_scenes import FrameScenes, frame_scenes
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Motion, Scene

OPTIONS: Mapping[str, Any] = {
    "frames": "",
    "motion": "truth",
    "score_threshold": 0.3,
    "patches": "",
}
"""``frames``: folders with the scenarios' images, with commas, where --scenarios names the authors'
labelled scenarios; ``motion``: see `Motion`; ``patches``: a folder of trained patches instead of
those of the package."""


_WORK = "avsec_gym.experiments.chapter5.attacked_drives:AttackedDrives"
_SHIPPED_PATCHES = Path(attacks.__file__).parent / "patches"


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


def attacked_inputs(configuration: Configuration) -> dict[str, Path]:
    """Weights, patches and the images' manifests."""
    folder = Path({**OPTIONS, **configuration.options}["patches"] or _SHIPPED_PATCHES)
    weights = {f"weights of {name}": shipped_weights(f"{name}_small") for name in DETECTORS}
    patches = {f"patch {path.stem}": path for path in sorted(folder.glob("*.safetensors"))}
    roots = {data.root for data in scenes_of(configuration).data.values()}
    manifests = {
        f"frames {number}": root / "manifest.json"
        for number, root in enumerate(sorted(roots), start=1)
        if (root / "manifest.json").is_file()
    }
    return {**weights, **patches, **manifests}


def scenes_of(configuration: Configuration) -> FrameScenes:
    """The scenes of a run, with their sensor data."""
    options = {**OPTIONS, **configuration.options}
    return _scenes(
        configuration.scenarios, options["frames"], configuration.limit, configuration.seed
    )


@cache
def _scenes(scenarios: str, frames: str, limit: int | None, seed: int) -> FrameScenes:
    if not frames:
        return frame_scenes(scenarios, count=limit, seed=seed)
    return frame_scenes(frames.split(","), scenarios=scenarios, count=limit, seed=seed)


@dataclass(frozen=True, eq=False)
class _Look:
    """What the car is shown, and what the results are filed under."""

    frame: SensorFrame
    attack: str
    strength: float = 0.0
    intentions: tuple[Intention, ...] = tuple(Intention)
    """Which of them drive by it."""
    seen_as: str = ""
    """Detections of a specific attack are filed by intention; empty: as the drives."""
    aims_at: Intention | None = None
    """Where a random patch happens to stand."""
    whole_levels: bool = False


@dataclass(frozen=True, eq=False)
class _Result:
    """What has come together so far."""

    drives: list[DriveRow] = field(default_factory=list)
    detections: list[DetectionRow] = field(default_factory=list)
    measurements: list[Measurement] = field(default_factory=list)
    seconds: dict[str, float] = field(default_factory=dict)

    @contextmanager
    def timed(self, part: str) -> Iterator[None]:
        start = time.perf_counter()
        yield
        self.seconds[part] = self.seconds.get(part, 0.0) + time.perf_counter() - start


class AttackedDrives:
    """Attacks, looks and drives; see `avsec_gym.experiments.experiment.Work`.

    Args:
        configuration: Of the run.
    """

    def __init__(self, configuration: Configuration) -> None:
        self._options = {**OPTIONS, **configuration.options}
        self._seed = configuration.seed
        self._scenes = scenes_of(configuration)
        self._by_id = {scene.id: scene for scene in self._scenes.scenes.labelled}
        self._pipelines: dict[str, Pipeline] = {}

    def __call__(self, detector: str, attack: str, scenario: str) -> CellResult:
        """The results of one cell.

        Args:
            detector: Its name.
            attack: See `avsec_gym.experiments.chapter5.settings`.
            scenario: The scene's id.

        Raises:
            ConfigurationError: There is no such attack.
            DataError: A file is missing or broken.
        """
        scene, pipeline = self._by_id[scenario], self._pipeline(detector)
        clean = self._scenes.frame(scene)
        victim = Victim(pipeline.detector, scene.boxes, None, self._scenes.disparity(scene))
        result = _Result()
        looks = self._looks(attack, scene, clean, victim)
        while True:
            with result.timed("attack"):
                look = next(looks, None)
            if look is None:
                return CellResult(
                    result.drives, result.detections, result.measurements, result.seconds
                )
            _take(result, look, scene, pipeline)
            if not look.whole_levels and look.strength in (0, STEPS):
                with result.timed("measuring"):
                    _measure(result, look, scene, clean, victim)

    def _looks(
        self, attack: str, scene: Scene, clean: SensorFrame, victim: Victim
    ) -> Iterator[_Look]:
        seed = (self._seed, scene.number)
        kind, _, rest = attack.partition("-")
        if attack == UNATTACKED:
            yield _Look(clean, attack)
        elif kind == "pgd":
            yield from _perturbed(attack, float(rest), clean, victim)
        elif kind == "noise":
            noisy = RandomNoise(STEPS * float(rest)).attack(clean, victim, seed)
            yield _Look(noisy, attack, STEPS)
        elif attack == TEXTURE:
            folder = self._scenes.data[scene.id].folder
            changed = replace_texture(clean, read_roadside(folder, scene.id), seed)
            yield _Look(changed, attack)
            yield from _perturbed(f"{attack}-pgd-1", 1.0, changed, victim)
        elif attack in PATCHES + JOINT_PATCHES + GREY_PATCHES:
            patch = PatchAttack(self._patch(kind, victim.detector.name), rest)  # type: ignore[arg-type]
            yield from _patched(attack, patch, clean, victim, seed)
        else:
            raise ConfigurationError(f"chapter 5 has no attack {attack!r}")

    def _patch(self, kind: str, detector: str) -> str | Path:
        if kind == "grey":
            return kind
        folder = Path(self._options["patches"] or _SHIPPED_PATCHES)
        return folder / f"{'joint' if kind == 'joint' else detector}.safetensors"

    def _pipeline(self, detector: str) -> Pipeline:
        if detector not in self._pipelines:
            self._pipelines[detector] = Pipeline(
                detector,
                motion=Motion.named(self._options["motion"]),
                score_threshold=self._options["score_threshold"],
                whole_levels=False,
            )
        return self._pipelines[detector]


def _perturbed(attack: str, alpha: float, clean: SensorFrame, victim: Victim) -> Iterator[_Look]:
    """Every n, as the attack leaves the pixels, and as a camera would deliver them."""
    iterates = Perturbation(alpha, steps=STEPS).iterates(clean, victim)
    for n, frame in enumerate(iterates, start=1):
        yield _Look(frame, attack, n)
        yield _Look(quantised(frame), attack, n, whole_levels=True)


def _patched(
    attack: str, patch: PatchAttack, clean: SensorFrame, victim: Victim, seed: tuple[int, int]
) -> Iterator[_Look]:
    """One look for all intentions, or for each its own; a printed patch has whole levels anyway."""
    if patch.placement == "random":
        aim = patch.placed(clean, victim, seed).intention(clean.image(LEFT).shape[1])
        yield _Look(quantised(patch.attack(clean, victim, seed)), attack, aims_at=aim)
        return
    for number, intention in enumerate(Intention):
        aimed = replace(victim, intention=intention)
        frame = quantised(patch.attack(clean, aimed, (*seed, number)))
        seen_as = specific(attack, intention)
        yield _Look(frame, attack, intentions=(intention,), seen_as=seen_as)


def _take(result: _Result, look: _Look, scene: Scene, pipeline: Pipeline) -> None:
    """Add what is seen, and the drives that follow."""
    name = pipeline.detector.name
    with result.timed("detector"):
        perception = pipeline.perceive(look.frame)
    seen = setting(name, look.seen_as or look.attack, whole_levels=look.whole_levels)
    result.detections.append(DetectionRow(seen, scene.id, perception.detections, look.strength))
    under = setting(name, look.attack, whole_levels=look.whole_levels)
    with result.timed("planner"):
        for intention in look.intentions:
            record = pipeline.drive(scene, perception, intention).record
            result.drives.append(DriveRow(under, record, look.strength))


def _measure(
    result: _Result, look: _Look, scene: Scene, clean: SensorFrame, victim: Victim
) -> None:
    """Add the loss against the truth, the largest change of a grey level, and where a patch is."""
    changes = [
        np.abs(np.subtract(look.frame.image(camera), clean.image(camera), dtype=float)).max()
        for camera in (LEFT, RIGHT)
    ]
    numbers = {"change": float(max(changes))}
    if look.aims_at is not None:
        numbers["attack_intention"] = list(Intention).index(look.aims_at)
    if isinstance(victim.detector, DifferentiableDetector):
        given = victim.disparity
        disparity = None if given is None else torch.from_numpy(given)[None]
        with torch.no_grad():
            batch = batch_of_frames([look.frame])
            numbers["loss"] = float(total_loss(victim.detector, batch, [victim.truth], disparity))
    filed = setting(victim.detector.name, look.seen_as or look.attack)
    for name, value in numbers.items():
        result.measurements.append(Measurement(filed, scene.id, name, value, look.strength))
