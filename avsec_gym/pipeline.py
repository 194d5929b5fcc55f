"""The thesis' chain (section 5.3.1), an attacker in front, a judge behind.

    b = O(I_l, I_r)                   detected objects
    b> = C(b, I_l, I_r)               which of them move
    (s_0, r, d) = S(I_l, I_r)         driving constraints, by road type
    {s_t} = M(b>, s_0, r, g, c, d)    the planned trajectory

and {s_t} is held against what is really there.  A validator may sit before O: at an alarm the car
stops, or goes on without the sensors that the alarm is about.  `Pipeline` is the whole chain,
`drive` its end for boxes that somebody hands in.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avsec_gym.attacks.attack import Seed, Victim, quantised
from avsec_gym.attacks.attacked_detector import attack_kind
from avsec_gym.attacks.optical_attack import OpticalAttack
from avsec_gym.boxes import Boxes3D
from avsec_gym.emergency_stop import emergency_stop, judge_stop
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.image_only import check_detector
from avsec_gym.kitti.detections import above
from avsec_gym.metrics.safety import SafetyRecord, judge
from avsec_gym.planners.plan import Plan
from avsec_gym.planners.planner import MotionPrimitivePlanner, Planner
from avsec_gym.registry import Kind, make
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.given_scene import GivenScene
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.planning_scenario import Obstacles, PlanningScenario
from avsec_gym.scenario.scene import Motion, Scene
from avsec_gym.validation.compromised_sensors import Untrusted
from avsec_gym.validation.response import Response, trusted_frame
from avsec_gym.validation.validator import Validation


@dataclass(frozen=True, eq=False)
class Drive:
    """One drive through a scene."""

    problem: PlanningScenario
    """What the planner was asked: the world as it was believed to be."""
    plan: Plan
    truth: Obstacles
    """The world as it is."""
    record: SafetyRecord


@dataclass(frozen=True, eq=False)
class Perception:
    """What the car believes after one look."""

    detections: Boxes3D
    """Everything that O reports, b."""
    believed: Boxes3D
    """What is planned on: those that are sure enough, with motion, b>."""
    road_type: RoadType | None
    """What S says; None: nobody was asked, and the scene's own holds."""
    seconds: dict[str, float] = field(default_factory=dict)
    """Of each part."""
    validation: Validation | None = None
    """What the validator says of the sensors; None: there is none."""
    stops: bool = False
    """Whether the car brings itself to a stand, whatever else is believed."""


@dataclass(frozen=True, eq=False)
class PipelineRun:
    """One situation from the sensors to the verdict."""

    frame: SensorFrame
    """What the car saw."""
    perception: Perception
    drive: Drive
    seconds: dict[str, float]
    """Of the attack, each part and the planner with the verdict."""


@dataclass(frozen=True, eq=False)
class Pipeline:
    """Attack, O, C, S, M, verdict; each part by name, as a dictionary, or as an object.

    Args:
        detector: O.
        attack: On what detectors see, or an optical one; None: nobody attacks.
        classifier: C; None: the planner knows of motion what `motion` says.
        selector: S; None: the scene's own road type holds.
        planner: M.
        motion: Without C, what the planner takes as moving.
        score_threshold: Less sure detections are not planned on.
        whole_levels: Whether attacked images have whole grey levels, as a camera's have.
        validator: Sits before O; None: the sensors are trusted.
        response: To its alarm.

    Raises:
        ConfigurationError: Nothing has one of the names, the detector finds 2D boxes alone, or a
            validator is to judge broken levels.

    Example:
        >>> pipeline = Pipeline("oracle")
        >>> pipeline.planner.algorithm
        <Algorithm.ASTAR: 'astar'>
    """

    detector: Any
    attack: Any = None
    classifier: Any = None
    selector: Any = None
    planner: Any = "astar"
    motion: Motion = Motion.TRUTH
    score_threshold: float = 0.3
    whole_levels: bool = True
    validator: Any = None
    response: Response | str = Response.STOP

    def __post_init__(self) -> None:
        object.__setattr__(self, "motion", Motion.named(self.motion))
        object.__setattr__(self, "response", Response.named(self.response))
        for kind in (
            Kind.DETECTOR,
            Kind.ATTACK,
            Kind.CLASSIFIER,
            Kind.SELECTOR,
            Kind.PLANNER,
            Kind.VALIDATOR,
        ):
            part = getattr(self, kind)
            chosen = attack_kind(part) if kind == Kind.ATTACK else kind
            object.__setattr__(self, kind, None if part is None else make(chosen, part))
        check_detector(self.detector)
        if self.validator is not None and not self.whole_levels:
            raise ConfigurationError("a validator judges images of whole grey levels")

    def __call__(
        self,
        scene: Scene,
        frame: SensorFrame,
        intention: Intention = Intention.STRAIGHT,
        *,
        seed: Seed = 0,
        disparity: NDArray[np.float32] | None = None,
    ) -> PipelineRun:
        """One situation, from the sensors to the verdict.

        Args:
            scene: What is really there.
            frame: What the sensors deliver of it.
            intention: Where to go.
            seed: Of the attack.
            disparity: See `Victim`.
        """
        seconds: dict[str, float] = {}
        with _timed(seconds, "attack"):
            seen = self.tampered(scene, frame, intention, seed=seed, disparity=disparity)
        perception = self.perceive(seen)
        with _timed(seconds, "planner"):
            driven = self.drive(scene, perception, intention)
        return PipelineRun(seen, perception, driven, {**seconds, **perception.seconds})

    def tampered(
        self,
        scene: Scene,
        frame: SensorFrame,
        intention: Intention | None = None,
        *,
        seed: Seed = 0,
        disparity: NDArray[np.float32] | None = None,
    ) -> SensorFrame:
        """The frame as the attacker lets it through; arguments as above."""
        if self.attack is None:
            return frame
        if isinstance(self.attack, OpticalAttack):
            return self.attack.attack(frame, seed).frame
        victim = Victim(self.detector, scene.boxes, intention, disparity)
        attacked: SensorFrame = self.attack.attack(frame, victim, seed)
        return quantised(attacked) if self.whole_levels else attacked

    def perceive(self, frame: SensorFrame, validation: Validation | None = None) -> Perception:
        """What the car believes: the validator's word first, then O, C and S.

        Args:
            frame: What it sees.
            validation: What the validator said of it; None: it is asked.
        """
        seconds: dict[str, float] = {}
        if self.validator is None:
            return self._believed(frame, seconds)
        if validation is None:
            with _timed(seconds, "validator"):
                validation = self.validator.validate(frame)
        try:
            trusted = trusted_frame(frame, validation, Response(self.response))
            return replace(self._believed(trusted, seconds), validation=validation)
        except Untrusted:
            nothing = Boxes3D.empty()
            return Perception(nothing, nothing, None, seconds, validation, stops=True)

    def perceive_all(self, frames: Sequence[SensorFrame]) -> list[Perception]:
        """The same for frames of one size, which pass through O together, or are judged first."""
        if self.validator is not None:
            return [self.perceive(frame) for frame in frames]
        from avsec_gym.perception.stereo_batch import batch_of_frames

        start = time.perf_counter()
        every = self.detector.detect_batch(batch_of_frames(frames))
        each = (time.perf_counter() - start) / max(len(frames), 1)
        return [
            self._understood(frame, detections, {"detector": each})
            for frame, detections in zip(frames, every, strict=True)
        ]

    def drive(
        self, scene: Scene, perception: Perception, intention: Intention = Intention.STRAIGHT
    ) -> Drive:
        """Where that leads: M, or a stop, and the verdict."""
        if perception.stops:
            return stop(scene, intention)
        return drive(
            scene,
            intention,
            perception.believed,
            motion=self.motion if self.classifier is None else Motion.CLASSIFIER,
            planner=self.planner,
            road_type=perception.road_type,
        )

    def _believed(self, frame: SensorFrame, seconds: dict[str, float]) -> Perception:
        with _timed(seconds, "detector"):
            detections: Boxes3D = self.detector.detect(frame)
        return self._understood(frame, detections, seconds)

    def _understood(
        self, frame: SensorFrame, detections: Boxes3D, seconds: dict[str, float]
    ) -> Perception:
        believed = above(detections, self.score_threshold)
        # C and S read the images as a camera delivers them.
        frame = quantised(frame) if self.classifier or self.selector else frame
        if self.classifier is not None:
            with _timed(seconds, "classifier"):
                believed = self.classifier.classify(believed, frame)
        road_type = None
        if self.selector is not None:
            with _timed(seconds, "selector"):
                road_type = self.selector.select(frame)
        return Perception(detections, believed, road_type, seconds)


def drive(
    scene: Scene | GivenScene,
    intention: Intention = Intention.STRAIGHT,
    believed: Boxes3D | None = None,
    *,
    motion: Motion = Motion.TRUTH,
    planner: Planner | None = None,
    road_type: RoadType | None = None,
) -> Drive:
    """Plan on what is believed, judge against what is.

    Args:
        scene: The real situation.
        intention: Where to go; a given scene has its own goal.
        believed: What perception reports; None: the truth.
        motion: What the planner knows of motion.
        planner: Any planner; None: A* over motion primitives.
        road_type: What the car believes to drive on; None: the truth.

    Raises:
        ConfigurationError: Motion is to come from a classifier, and the boxes have no `moving`.

    Example:
        >>> from avsec_gym.world.layouts import generate_layout
        >>> layout = generate_layout(7)
        >>> scene = Scene(layout.id, layout.boxes, layout.road_type)
        >>> drive(scene).record.outcome
        'safe'
    """
    planner = MotionPrimitivePlanner() if planner is None else planner
    problem = scene.problem(intention, believed, motion, road_type)
    plan = planner.plan(problem)
    truth = scene.truth()
    return Drive(problem, plan, truth, judge(plan, problem, truth))


def stop(scene: Scene | GivenScene, intention: Intention = Intention.STRAIGHT) -> Drive:
    """Brake, wherever the car wanted to go, and judge that against what is.

    Args:
        scene: The real situation.
        intention: That is given up.
    """
    problem = scene.problem(intention, Boxes3D.empty(), Motion.STATIC)
    plan, truth = emergency_stop(problem), scene.truth()
    return Drive(problem, plan, truth, judge_stop(plan, problem, truth))


@contextmanager
def _timed(seconds: dict[str, float], part: str) -> Iterator[None]:
    start = time.perf_counter()
    try:
        yield
    finally:
        seconds[part] = time.perf_counter() - start
