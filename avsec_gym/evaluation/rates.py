"""The main job: success, collision and safe-driving rates of a set of scenes.

Thesis, section 5.4: every scene is driven with every intention, once with the ground truth as the
planner's input and once with a detector's boxes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.kitti.detections import above, default_score_threshold
from avsec_gym.metrics.paired import PairedRates, holm_p, paired_differences
from avsec_gym.metrics.safety import SafetyRates, SafetyRecord
from avsec_gym.pipeline import run_episode
from avsec_gym.planners.planner import Algorithm, MotionPrimitivePlanner, Planner
from avsec_gym.progress import Progress, no_progress
from avsec_gym.scenario.given_scene import AS_GIVEN, GivenScene
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Motion, Scene
from avsec_gym.scenario.scene_set import SceneSet
from avsec_gym.scenario.scene_sets import WITHOUT_CARS

GROUND_TRUTH, DETECTIONS = "ground_truth", "detections"
"""Inputs of the planner."""

AnyScene = Scene | GivenScene


@dataclass(frozen=True, eq=False)
class Detected:
    """A detector's boxes for a set of scenes.

    Args:
        boxes: The boxes by scene id; a scene without an entry has no detections.
        threshold: Boxes with lower scores are dropped; None: 0.3 where all scores are
            probabilities, else 0.
        missing: Scenes that the detector's folder has no file for.
    """

    boxes: Mapping[str, Boxes3D]
    threshold: float | None = None
    missing: tuple[str, ...] = ()

    @property
    def score_threshold(self) -> float:
        """The threshold in use."""
        if self.threshold is not None:
            return self.threshold
        return default_score_threshold(self.all_scores)

    @property
    def all_scores(self) -> np.ndarray:
        """Every score, shape (K,)."""
        return np.concatenate([boxes.score for boxes in self.boxes.values()] or [np.zeros(0)])

    def kept(self, threshold: float | None = None) -> dict[str, Boxes3D]:
        """The boxes at or above a threshold; None: the one in use."""
        limit = self.score_threshold if threshold is None else threshold
        return {id: above(boxes, limit) for id, boxes in self.boxes.items()}


@dataclass(frozen=True)
class RatesKey:
    """A row of the thesis' tables: a planner, an intention, and what is planned on.

    Args:
        planner: The planner's name.
        intention: The driving intention.
        input: `GROUND_TRUTH` or `DETECTIONS`.
    """

    planner: str
    intention: str
    input: str


@dataclass(frozen=True, eq=False)
class DrivingSafety:
    """Records of all rows, and the figures that follow from them."""

    scenes: SceneSet
    records: dict[RatesKey, list[SafetyRecord]]
    settings: dict[str, Any] = field(default_factory=dict)

    def rates(
        self, cell: RatesKey, keep: Callable[[AnyScene], bool] = lambda scene: True
    ) -> SafetyRates:
        """The rates of one row, over the scenes that are kept."""
        pairs = zip(self.scenes.driven(cell.intention), self.records[cell], strict=True)
        return SafetyRates.of(record for scene, record in pairs if keep(scene))

    def flips(
        self, planner: str, intention: str
    ) -> list[tuple[AnyScene, SafetyRecord, SafetyRecord]]:
        """Scenes that are safe with the ground truth and unsafe with the detections."""
        truth = self.records[RatesKey(planner, intention, GROUND_TRUTH)]
        detected = self.records[RatesKey(planner, intention, DETECTIONS)]
        return [
            (scene, one, two)
            for scene, one, two in zip(self.scenes.driven(intention), truth, detected, strict=True)
            if one.safe and not two.safe
        ]

    def to_json(self) -> dict[str, Any]:
        """Everything but the single records."""
        groups = sorted({scene.group for scene in self.scenes.scenes})
        by_group = [
            {"group": group, **_named(cell), **self.rates(cell, in_group(group)).to_json()}
            for cell in self.records
            for group in groups
        ]
        if WITHOUT_CARS in groups:
            by_group += [
                {"group": f"all but {WITHOUT_CARS}", **_named(cell), **rates.to_json()}
                for cell in self.records
                for rates in [self.rates(cell, lambda scene: scene.group != WITHOUT_CARS)]
            ]
        return {
            "rates": [{**_named(cell), **self.rates(cell).to_json()} for cell in self.records],
            "rates_by_group": by_group,
            "differences": [difference.to_json() for difference in self.differences()],
            "unplanned": [
                {
                    **_named(cell),
                    "scenario": record.scenario,
                    "reason": record.reason,
                    "goal_occupied": record.to_json()["goal_occupied"],
                }
                for cell, records in self.records.items()
                for record in records
                if not record.planned
            ],
            "flips": [
                {
                    "planner": cell.planner,
                    "intention": cell.intention,
                    "scenario": scene.id,
                    "outcome": detected.outcome,
                    "reason": detected.reason,
                }
                for cell in self.records
                if cell.input == DETECTIONS
                for scene, _, detected in self.flips(cell.planner, cell.intention)
            ],
            "scenario_set": self.scenes.name,
            "remarks": list(self.scenes.remarks),
            "settings": self.settings,
        }

    def differences(self) -> list[Difference]:
        """Detections minus ground truth by planner and intention, and all intentions pooled."""
        names, pairs = [], []
        pooled: dict[str, tuple[list[SafetyRecord], list[SafetyRecord]]] = {}
        for cell, records in self.records.items():
            truth = self.records.get(RatesKey(cell.planner, cell.intention, GROUND_TRUTH))
            if cell.input != DETECTIONS or truth is None:
                continue
            first, second = pooled.setdefault(cell.planner, ([], []))
            first += truth
            second += records
            names.append((cell.planner, cell.intention))
            pairs.append(paired_differences(truth, records))
        for planner, (first, second) in pooled.items():
            names.append((planner, "all"))
            pairs.append(paired_differences(first, second))
        return [
            Difference(planner, intention, paired, p)
            for (planner, intention), paired, p in zip(names, pairs, holm_p(pairs), strict=True)
        ]


@dataclass(frozen=True)
class Difference:
    """Detections against the ground truth on the same scenes.

    Args:
        planner: The planner's name.
        intention: The driving intention, or ``all``.
        paired: Differences of the rates; None without a scene.
        mcnemar_p_holm: McNemar's p after Holm's correction for all rows; None: there is none.
    """

    planner: str
    intention: str
    paired: PairedRates | None
    mcnemar_p_holm: float | None

    def to_json(self) -> dict[str, Any]:
        """All of it, flat."""
        return {
            "planner": self.planner,
            "intention": self.intention,
            **paired_json(self.paired),
            "mcnemar_p_holm": self.mcnemar_p_holm,
        }


def paired_json(paired: PairedRates | None) -> dict[str, object]:
    """Differences as JSON; without a scene, their number."""
    return {"scenarios": 0} if paired is None else paired.to_json()


def driving_safety(
    scenes: SceneSet,
    *,
    planners: Sequence[str] = (Algorithm.ASTAR,),
    intentions: Sequence[Intention] = tuple(Intention),
    detected: Detected | None = None,
    truth_motion: Motion = Motion.TRUTH,
    detected_motion: Motion = Motion.STATIC,
    planner_of: Callable[[str], Planner] | None = None,
    on_progress: Progress = no_progress,
) -> DrivingSafety:
    """Drive every scene.

    Args:
        scenes: The scenes.
        planners: Names that the records are filed under.
        intentions: The driving intentions.
        detected: A detector's boxes; None: the ground truth is the only input.
        truth_motion: What the planner knows of motion when it plans on the ground truth.
        detected_motion: The same for detections.
        planner_of: The planner of a name; None: the names are those of search algorithms.
        on_progress: Function that gets the number of episodes that are done, and of all.
    """
    # What is planned on: the truth, and the detections where there are some.
    inputs: list[tuple[str, Mapping[str, Boxes3D] | None, Motion]] = [
        (GROUND_TRUTH, None, truth_motion)
    ]
    if detected is not None:
        inputs.append((DETECTIONS, detected.kept(), detected_motion))
    given = any(isinstance(scene, GivenScene) for scene in scenes.scenes)
    # Given scenes have a goal of their own: there is one way to go.
    ways = [AS_GIVEN] if given else [str(intention) for intention in intentions]
    records: dict[RatesKey, list[SafetyRecord]] = {}
    total = sum(len(scenes.driven(way)) for way in ways) * len(planners) * len(inputs)
    planner_of = _searching if planner_of is None else planner_of
    # Every scene is driven by every planner, with every intention, on every input.
    for name_of_planner in planners:
        planner = planner_of(name_of_planner)
        for way in ways:
            intention = Intention.STRAIGHT if given else Intention(way)
            for name, boxes, motion in inputs:
                cell = RatesKey(str(name_of_planner), way, name)
                records[cell] = []
                for record in _episodes(scenes.driven(way), planner, intention, boxes, motion):
                    records[cell].append(record)
                    on_progress(sum(map(len, records.values())), total)
    # What the records depend on.
    settings: dict[str, Any] = {"motion": {GROUND_TRUTH: str(truth_motion)}}
    if detected is not None:
        settings["motion"][DETECTIONS] = str(detected_motion)
        settings["score_threshold"] = detected.score_threshold
        settings["frames_without_detections"] = list(detected.missing)
    return DrivingSafety(scenes, records, settings)


def threshold_sweep(
    scenes: SceneSet,
    detected: Detected,
    thresholds: Iterable[float],
    *,
    planner: str = Algorithm.ASTAR,
    intentions: Sequence[Intention] = tuple(Intention),
    motion: Motion = Motion.STATIC,
    planner_of: Callable[[str], Planner] | None = None,
) -> list[dict[str, Any]]:
    """The rates with detections at several score thresholds; arguments as of `driving_safety`."""
    driver = (_searching if planner_of is None else planner_of)(planner)
    return [
        {
            "score_threshold": float(threshold),
            "planner": str(planner),
            "intention": str(intention),
            **SafetyRates.of(
                _episodes(
                    scenes.driven(str(intention)),
                    driver,
                    intention,
                    detected.kept(threshold),
                    motion,
                )
            ).to_json(),
        }
        for threshold in thresholds
        for intention in intentions
    ]


def _searching(name: str) -> Planner:
    return MotionPrimitivePlanner(Algorithm(name))


def _episodes(
    scenes: Iterable[AnyScene],
    planner: Planner,
    intention: Intention,
    boxes: Mapping[str, Boxes3D] | None,
    motion: Motion,
) -> Iterable[SafetyRecord]:
    nothing = Boxes3D.empty()
    for scene in scenes:
        believed = None if boxes is None else boxes.get(scene.id, nothing)
        yield run_episode(scene, intention, believed, motion=motion, planner=planner).record


def _named(cell: RatesKey) -> dict[str, str]:
    return {"planner": cell.planner, "intention": cell.intention, "input": cell.input}


def in_group(group: str) -> Callable[[AnyScene], bool]:
    """Whether a scene belongs to a group."""
    return lambda scene: scene.group == group
