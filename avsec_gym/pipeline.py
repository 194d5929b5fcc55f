"""The thesis' chain (section 5.3.1), an attacker before it, the collision check after it.

    b = O(I_l, I_r)                   detected objects
    b> = C(b, I_l, I_r)               which of them move
    (s_0, r, d) = S(I_l, I_r)         driving constraints, by road type
    {s_t} = M(b>, s_0, r, g, c, d)    the planned trajectory

and {s_t} is checked for collisions with what is really there.  A validator may stand before O: at
an alarm the car stops, or goes on without the sensors that the alarm is about.  `Pipeline` is the
whole chain, `run_episode` its end, from given boxes on.
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
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.planning_scenario import PlanningScenario
from avsec_gym.scenario.scene import Motion, Scene
from avsec_gym.validation.compromised_sensors import Untrusted
from avsec_gym.validation.response import Response, trusted_frame
from avsec_gym.validation.validator import Judgement


@dataclass(frozen=True, eq=False)
class Episode:
    """One planned trajectory through a scene, and its check.

    Args:
        problem: The planner's problem: the world as the car believes it to be.
        plan: The planner's answer.
        truth: The obstacles that are really there.
        record: The outcome of the collision check.
    """

    problem: PlanningScenario
    plan: Plan
    truth: Obstacles
    record: SafetyRecord


@dataclass(frozen=True, eq=False)
class Perception:
    """What the car believes after it has processed one frame.

    Args:
        detections: All boxes that O reports, b.
        believed: The boxes that are planned on: those of a sufficient score, with motion, b>.
        road_type: The answer of S; None: there is no selector, and the scene's own type holds.
        seconds: The time that each part took, by its name.
        validation: The validator's result; None: there is no validator.
        stops: Whether the car makes an emergency stop, whatever else it believes.
    """

    detections: Boxes3D
    believed: Boxes3D
    road_type: RoadType | None
    seconds: dict[str, float] = field(default_factory=dict)
    validation: Judgement | None = None
    stops: bool = False


@dataclass(frozen=True, eq=False)
class PipelineRun:
    """One scene from the sensors to the collision check.

    Args:
        frame: The frame that the car received, attacked or not.
        perception: What the car believed.
        episode: The trajectory that it planned, and the check.
        seconds: The time that the attack, each part, and the planner with the check took.
    """

    frame: SensorFrame
    perception: Perception
    episode: Episode
    seconds: dict[str, float]


@dataclass(frozen=True, eq=False)
class Pipeline:
    """Attack, O, C, S, M, collision check; each part by name, as a dictionary, or as an object.

    Args:
        detector: The detector O.
        attack: The attack on what the detector sees, or an optical one; None: no attack.
        classifier: The moving-object classifier C; None: `motion` decides which objects move.
        selector: The driving-constraint selector S; None: the scene's own road type holds.
        planner: The motion planner M.
        motion: The objects that the planner takes as moving where there is no classifier.
        score_threshold: The least score of a detection that is planned on.
        whole_levels: Whether attacked images have whole grey levels, as a camera's have.
        validator: The validator before O; None: the sensors are trusted.  ``connected`` judges the
            LiDAR by what other vehicles scan (`SensorFrame.connected`).
        response: The car's response to the validator's alarm; None: it drives on, and the alarm is
            only reported.
        victim: The detector that the attack knows; None: the car's.

    Raises:
        ConfigurationError: Nothing has one of the names, the detector finds 2D boxes alone, or a
            validator is combined with images of broken grey levels.

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
    response: Response | str | None = Response.STOP
    victim: Any = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "motion", Motion.named(self.motion))
        if self.response is not None:
            object.__setattr__(self, "response", Response.named(self.response))
        if self.victim is not None:
            object.__setattr__(self, "victim", make(Kind.DETECTOR, self.victim))
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
        """One scene, from the sensors to the collision check.

        Args:
            scene: The real scene.
            frame: The clean frame of it.
            intention: The driving intention.
            seed: The seed of the attack.
            disparity: The true disparities that `Victim` describes.
        """
        seconds: dict[str, float] = {}
        with _timed(seconds, "attack"):
            seen = self.tampered(scene, frame, intention, seed=seed, disparity=disparity)
        perception = self.perceive(seen)
        with _timed(seconds, "planner"):
            episode = self.run_episode(scene, perception, intention)
        return PipelineRun(seen, perception, episode, {**seconds, **perception.seconds})

    def tampered(
        self,
        scene: Scene,
        frame: SensorFrame,
        intention: Intention | None = None,
        *,
        seed: Seed = 0,
        disparity: NDArray[np.float32] | None = None,
    ) -> SensorFrame:
        """The frame after the attack; arguments as of the call."""
        if self.attack is None:
            return frame
        if isinstance(self.attack, OpticalAttack):
            return self.attack.attack(frame, seed).frame
        detector = self.detector if self.victim is None else self.victim
        victim = Victim(detector, scene.boxes, intention, disparity)
        attacked: SensorFrame = self.attack.attack(frame, victim, seed)
        return quantised(attacked) if self.whole_levels else attacked

    def perceive(self, frame: SensorFrame, validation: Judgement | None = None) -> Perception:
        """What the car believes: the validator first, then O, C and S.

        Args:
            frame: The frame that the car receives.
            validation: The validator's result on it, where it is known; None: it is computed.
        """
        seconds: dict[str, float] = {}
        if self.validator is None:
            return self._believed(frame, seconds)
        if validation is None:
            with _timed(seconds, "validator"):
                validation = self.validator.validate(frame)
        try:
            trusted = self.trusted(frame, validation)
            return replace(self._believed(trusted, seconds), validation=validation)
        except Untrusted:
            nothing = Boxes3D.empty()
            return Perception(nothing, nothing, None, seconds, validation, stops=True)

    def trusted(self, frame: SensorFrame, validation: Judgement | None) -> SensorFrame:
        """The frame that O gets, in response to the validator's result on it.

        Raises:
            Untrusted: The car stops.  The frame itself may raise it later, when it is asked for
                data that nothing can replace.
        """
        if validation is None or self.response is None:
            return frame
        return trusted_frame(frame, validation, Response(self.response))

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

    def run_episode(
        self, scene: Scene, perception: Perception, intention: Intention = Intention.STRAIGHT
    ) -> Episode:
        """What follows from a perception: M, or an emergency stop, and the collision check."""
        if perception.stops:
            return stopped_episode(scene, intention)
        return run_episode(
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


def run_episode(
    scene: Scene | GivenScene,
    intention: Intention = Intention.STRAIGHT,
    believed: Boxes3D | None = None,
    *,
    motion: Motion = Motion.TRUTH,
    planner: Planner | None = None,
    road_type: RoadType | None = None,
) -> Episode:
    """Plan a trajectory on what is believed, and check it against what is there.

    Args:
        scene: The real scene.
        intention: The driving intention; a given scene has its own goal.
        believed: The boxes that perception reports; None: the truth.
        motion: The objects that the planner takes as moving.
        planner: The motion planner; None: A* over motion primitives.
        road_type: The type of the road as the car believes it; None: the truth.

    Raises:
        ConfigurationError: Motion is to come from a classifier, and the boxes have no `moving`.

    Example:
        >>> from avsec_gym.world.layouts import generate_layout
        >>> layout = generate_layout(7)
        >>> scene = Scene(layout.id, layout.boxes, layout.road_type)
        >>> run_episode(scene).record.outcome
        'safe'
    """
    planner = MotionPrimitivePlanner() if planner is None else planner
    problem = scene.problem(intention, believed, motion, road_type)
    plan = planner.plan(problem)
    truth = scene.truth()
    return Episode(problem, plan, truth, judge(plan, problem, truth))


def stopped_episode(
    scene: Scene | GivenScene, intention: Intention = Intention.STRAIGHT
) -> Episode:
    """Brake at once, and check that against what is there.

    Args:
        scene: The real scene.
        intention: The driving intention that the car gives up.
    """
    problem = scene.problem(intention, Boxes3D.empty(), Motion.STATIC)
    plan, truth = emergency_stop(problem), scene.truth()
    return Episode(problem, plan, truth, judge_stop(plan, problem, truth))


@contextmanager
def _timed(seconds: dict[str, float], part: str) -> Iterator[None]:
    start = time.perf_counter()
    try:
        yield
    finally:
        seconds[part] = time.perf_counter() - start
