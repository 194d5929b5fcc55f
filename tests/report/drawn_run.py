"""A run of chapter 5 whose detections are drawn from a seed instead of seen.

A module of its own, not a test: runs and worker processes import it by name (see conftest.py).
Everything behind the detections is real: planner, collision check, store.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter5.attacked_cells import attacked_cells
from avsec_gym.experiments.chapter5.feature_spread import FeatureSpread, LayerSpread, SpreadExtent
from avsec_gym.experiments.chapter5.patch_spreads import IMAGES, PatchSpreads
from avsec_gym.experiments.chapter5.scenes import OPTIONS, scenes_of
from avsec_gym.experiments.chapter5.settings import (
    DETECTORS,
    GREY_PATCHES,
    JOINT_PATCHES,
    NOISES,
    PATCHES,
    PERTURBATIONS,
    STEPS,
    TEXTURE,
    UNATTACKED,
    WITHOUT_PYRAMID,
    setting,
    specific,
)
from avsec_gym.experiments.chapter5.true_episodes import true_cells
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.detections import above
from avsec_gym.kitti.writing import write_object_frame
from avsec_gym.pipeline import Perception, PipelineRun, run_episode
from avsec_gym.rig import kitti_rig
from avsec_gym.runs.experiment import (
    Cell,
    CellResult,
    Configuration,
    DetectionRow,
    EpisodeRow,
    Experiment,
    Measurement,
)
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Scene
from avsec_gym.world.layouts import generate_layouts
from avsec_gym.world.layouts.view import observation_angle, project_boxes

ATTACKS = (
    UNATTACKED, *PERTURBATIONS, *PATCHES, *JOINT_PATCHES, TEXTURE, *NOISES, *GREY_PATCHES
)  # fmt: skip
SEES_ALL = {"dsgn": 0.85, "stereo_rcnn": 0.7, WITHOUT_PYRAMID: 0.8}
"""Share of the cars that each detector finds unattacked."""
FOOLED = {"dsgn": 0.05, "stereo_rcnn": 0.5, WITHOUT_PYRAMID: 0.5}
"""How often a patch makes each detector see a car where the patch is."""
CLEAR = {Intention.LEFT: 3.5, Intention.STRAIGHT: 0.0, Intention.RIGHT: -3.5}
FAILS = "000003"
"""This scene's patch is out of order, if a run is `broken`."""


class DrawnEpisodes:
    """Like `AttackedEpisodes`, with the same rows."""

    def __init__(self, configuration: Configuration) -> None:
        self._seed = configuration.seed
        self._broken = bool(configuration.options.get("broken"))
        self._frames = scenes_of(configuration)
        self._scenes = {scene.id: scene for scene in self._frames.scenes.labelled}

    def __call__(self, detector: str, attack: str, scenario: str) -> CellResult:
        if self._broken and (attack, scenario) == ("patch-random", FAILS):
            raise ZeroDivisionError("the printer is out of paper")
        scene = self._scenes[scenario]
        episodes, detections, measurements = [], [], []
        for name, strength, whole, intentions, seen_as in looks(attack):
            boxes = self._seen(detector, name, strength, scene, intentions)
            under = setting(detector, name, whole_levels=whole)
            filed = setting(detector, seen_as, whole_levels=whole)
            detections.append(DetectionRow(filed, scenario, boxes, strength))
            for way in intentions:
                record = run_episode(scene, way, above(boxes, 0.3)).record
                episodes.append(EpisodeRow(under, record, strength))
            if not whole and strength in (0, STEPS):
                facts = self._facts(detector, name, strength, scene)
                measurements += [
                    Measurement(filed, scenario, key, value, strength)
                    for key, value in facts.items()
                ]
        seconds = {"attack": 0.4 * len(episodes), "detector": 0.3, "planner": 0.01 * len(episodes)}
        return CellResult(episodes, detections, measurements, seconds)

    def again(
        self, detector: str, attack: str, scenario: str, intention: Intention,
        strength: float = 0.0, *, whole_levels: bool = False,
    ) -> PipelineRun:  # fmt: skip
        """As `AttackedEpisodes.again`; a perturbation is noise, a patch a magenta disc."""
        scene = self._scenes[scenario]
        frame = self._frames.frame(scene)
        boxes = self._seen(detector, attack, strength, scene, (intention,))
        for camera in (2, 3):
            frame = frame.with_image(camera, _attacked(frame.image(camera), attack, strength))
        perception = Perception(boxes, above(boxes, 0.3), None)
        return PipelineRun(
            frame, perception, run_episode(scene, intention, perception.believed), {}
        )

    def _seen(
        self, detector: str, attack: str, strength: float, scene: Scene, ways: tuple[Any, ...]
    ) -> Boxes3D:
        kind, _, rest = attack.rpartition("-") if "pgd" in attack else attack.partition("-")
        random = np.random.default_rng([self._seed, scene.number, *detector.encode()])
        cars = scene.boxes[scene.boxes.category == "Car"]
        draws = random.uniform(size=len(cars))
        shifts = random.normal(size=(len(cars), 3))
        change = strength * float(rest) if "pgd" in attack else 0.0
        found = draws < SEES_ALL[detector] * np.exp(-0.25 * change)
        boxes = cars[found]
        drift = shifts[found] * [0.1, 0.02, 0.15] * (1 + 3 * change)
        parts = [replace(boxes, location=boxes.location + drift)]
        own = np.random.default_rng([self._seed, scene.number, *attack.encode()])
        if change and not attack.startswith(TEXTURE):
            parts.append(_ghosts(own, own.poisson(change), beside=True))
        if change and detector == "stereo_rcnn" and own.uniform() < 0.02 * change:
            parts.append(_ghosts(own, 1, beside=False))
        if kind in ("patch", "joint") and own.uniform() < FOOLED[detector]:
            way = ways[0] if "specific" in attack else _aim(self._seed, scene)
            parts.append(_ghosts(own, 1, beside=False, x=-CLEAR[way]))
        return _looked_at(parts, random)

    def _facts(self, detector: str, attack: str, strength: float, scene: Scene) -> dict[str, float]:
        random = np.random.default_rng([1, self._seed, scene.number])
        clean = 1 + random.uniform()
        if "patch" in attack or "joint" in attack or "grey" in attack:
            lowered = 0.3 if "grey" not in attack else 0.98
            return {
                "change": 200.0, "loss": clean * 1.05, "clean_ghost_loss": 3 * clean,
                "ghost_loss": 3 * clean * lowered,
                "attack_intention": list(Intention).index(_aim(self._seed, scene)),
            }  # fmt: skip
        alpha = float(attack.rpartition("-")[2]) if "-" in attack else 0.0
        gain = 1.0 if "pgd" in attack else 0.01
        return {"change": strength * alpha, "loss": clean * (1 + gain * strength * alpha)}


class DrawnSpreads(PatchSpreads):
    """Like `PatchSpreads`, with two layers of discs, the second twice as wide."""

    def spread(self, detector: str, patch: str, images: str) -> FeatureSpread:
        distance = np.hypot(*np.mgrid[-30:30, -30:30])
        layers = [
            LayerSpread(
                name,
                np.maximum(wide - distance, 0),
                SpreadExtent(4.0, 0.1, 0.1, wide, wide, 2 * wide),
            )
            for name, wide in (("conv1", 10.0), ("conv2", 20.0))
        ]
        return FeatureSpread(np.full((60, 60, 3), 0.5), 10.0, tuple(layers))


def looks(attack: str) -> list[tuple[str, float, bool, tuple[Intention, ...], str]]:
    """Attack, strength, whole levels, who drives by it, and as what it is seen."""
    every = tuple(Intention)
    if attack == TEXTURE:
        after = f"{TEXTURE}-thesis_pgd-1"
        return [(TEXTURE, 0.0, False, every, TEXTURE), *_steps(after)]
    if attack in PERTURBATIONS:
        return _steps(attack)
    if attack.endswith("specific"):
        return [(attack, 0.0, False, (way,), specific(attack, way)) for way in Intention]
    return [(attack, float(STEPS if attack in NOISES else 0), False, every, attack)]


def _steps(attack: str) -> list[tuple[str, float, bool, tuple[Intention, ...], str]]:
    return [
        (attack, float(n), whole, tuple(Intention), attack)
        for n in range(1, STEPS + 1)
        for whole in (False, True)
    ]


def drawn_cells(configuration: Configuration, attacks: tuple[str, ...] = ATTACKS) -> list[Cell]:
    drawn = [
        Cell.of("drawn_run:DrawnEpisodes", cell.group, **cell.arguments)
        for cell in (
            *attacked_cells(configuration, attacks, DETECTORS),
            *attacked_cells(configuration, (UNATTACKED, *PATCHES), (WITHOUT_PYRAMID,)),
        )
    ]
    spread = [
        Cell.of("drawn_run:DrawnSpreads", name, detector=name, patch="noise", images=images)
        for name in DETECTORS
        for images in IMAGES
    ]
    return [*true_cells(configuration), *drawn, *spread]


def _experiment(name: str, attacks: tuple[str, ...]) -> Experiment:
    return Experiment(
        name, "Is it so?", "Chapter 5", lambda asked: drawn_cells(asked, attacks),
        options={**OPTIONS, "broken": False},
    )  # fmt: skip


DRAWN = _experiment("drawn", ATTACKS)
SOME = _experiment(
    "some",
    (UNATTACKED, PERTURBATIONS[1], *PATCHES, TEXTURE, NOISES[1]),
)


def write_frames(root: Path, count: int) -> Path:
    """Procedural layouts in KITTI's object layout, with flat images."""
    calibration = kitti_rig().calibration
    image = np.full((375, 1242, 3), 90, np.uint8)
    image[185:] = np.linspace(110, 160, 190).astype(np.uint8)[:, None, None]
    for number, layout in enumerate(generate_layouts(count)):
        frame = SensorFrame(f"{number:06d}", calibration, {2: image, 3: image})
        write_object_frame(root / "training", frame, layout.boxes)
    return root


def _aim(seed: int, scene: Scene) -> Intention:
    return list(Intention)[int(np.random.default_rng([seed, scene.number, 5]).integers(3))]


def _ghosts(random: np.random.Generator, count: int, *, beside: bool, x: float = 0.0) -> Boxes3D:
    away = (
        random.choice([-1, 1], count) * random.uniform(8, 16, count)
        if beside
        else np.full(count, x)
    )
    ahead = random.uniform(12, 35, count) if beside else random.uniform(12, 16, count)
    return Boxes3D(
        np.column_stack([away, np.full(count, 1.65), ahead]),
        np.tile([1.5, 1.65, 4.0], (count, 1)),
        np.full(count, -np.pi / 2), np.ones(count), np.full(count, "Car"),
    )  # fmt: skip


def _looked_at(parts: list[Boxes3D], random: np.random.Generator) -> Boxes3D:
    """As a detector reports them: 2D boxes, alpha, a score, best first."""
    fields = ("location", "dimensions", "rotation_y")
    columns = [np.concatenate([getattr(part, name) for part in parts]) for name in fields]
    location, dimensions, rotation_y = columns
    score = np.sort(random.uniform(0.35, 1, len(rotation_y)))[::-1]
    return Boxes3D(
        location, dimensions, rotation_y, score, np.full(len(score), "Car"),
        box2d=project_boxes(location, dimensions, rotation_y).box2d,
        alpha=observation_angle(location, rotation_y),
    )  # fmt: skip


def _attacked(image: np.ndarray, attack: str, strength: float) -> np.ndarray:
    random = np.random.default_rng(0)
    if "pgd" in attack:
        change = strength * random.choice([-1.0, 1.0], image.shape)
        return np.clip(image + change, 0, 255).astype(np.float32)
    if "patch" in attack or "joint" in attack:
        v, u = np.mgrid[: image.shape[0], : image.shape[1]]
        disc = (u - 600) ** 2 + (v - 200) ** 2 < 38**2
        return np.where(disc[..., None], np.uint8([220, 30, 180]), image)
    return image
