"""The parts of the pipeline that an environment's agent does not play, checked and made.

An environment is the pipeline with one part taken out, which the agent plays.  The others are
keyword arguments with the same names, defaults and meaning in every environment: names, JSON-able
dictionaries or live objects.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from avsec_gym.argument_checks import number
from avsec_gym.envs.game_validator import check_validator, is_measured, validator_and_played
from avsec_gym.envs.one_thread import one_thread
from avsec_gym.image_only import check_detector
from avsec_gym.pipeline import Pipeline
from avsec_gym.planners.planner import Planner
from avsec_gym.registry import Kind, check, make
from avsec_gym.scenario.frame_scenes import FrameScenes, check_frame_scenes, frame_scenes_of
from avsec_gym.scenario.scene import Motion

if TYPE_CHECKING:  # OpenCV is loaded with the validator, not before.
    from avsec_gym.validation.validator import Validator


@dataclass(frozen=True, eq=False)
class Parts:
    """What an environment on sensor data is made of, beside its agent.

    What cannot work is refused at once.  A bare name is looked up, and its part is made when it is
    asked for, as networks take seconds to load; a part with arguments is made at once, since only
    that shows whether they fit.  Nothing is measured, and no scene is read.

    Args:
        scenarios: Scenes with sensor data, as of `frame_scenes_of`.
        detector: Finds objects in the sensor data; not used where the agent does.
        planner: Plans the drive among the detected objects.
        motion: How much the planner knows of moving objects; there is no classifier.
        score_threshold: Detections of a lower score are not planned on, in [0, 1].
        validator: Looks for attacks on the sensors, see `validator_and_played`; None: none.
        clean: Scenes that thresholds of the validator are measured on; None: the first half of the
            scenarios.
        attack: The optical attack on the sensors, where the agent plays none; None: no attack.
        agent: The part that the agent plays.

    Raises:
        ConfigurationError: A name is unknown, an argument of a part does not fit, or a number is
            out of range.
        DataError: A folder of scenes or a file of weights is missing or broken.
    """

    scenarios: Any = "mixed"
    detector: Any = "dsgn"
    planner: Any = "astar"
    motion: Motion | str = Motion.STATIC
    score_threshold: float = 0.3
    validator: Any = None
    clean: Any = None
    attack: Any = None
    agent: Kind = Kind.ATTACK

    def __post_init__(self) -> None:
        checked: dict[str, Any] = {
            "score_threshold": number("score_threshold", self.score_threshold, 0.0, 1.0),
            "motion": Motion.without_classifier(self.motion),
        }
        check_frame_scenes(self.scenarios)
        check_validator(self.validator, self.clean)
        checked["planner"] = _checked(Kind.PLANNER, self.planner)
        if self.agent != Kind.DETECTOR:
            checked["detector"] = _checked(Kind.DETECTOR, self.detector)
            check_detector(checked["detector"])
        if self.validator is not None and not is_measured(self.validator):
            checked["validator"] = _checked(Kind.VALIDATOR, self.validator)
        if self.attack is not None:
            check(Kind.OPTICAL_ATTACK, self.attack)
            checked["attack"] = _made(Kind.OPTICAL_ATTACK, self.attack)
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    def scenes(self) -> FrameScenes:
        """The scenarios, all of them.

        Raises:
            DataError: A file is missing or broken.
        """
        return frame_scenes_of(self.scenarios)

    def validator_and_scenes(self) -> tuple[Validator | None, FrameScenes]:
        """The validator, and the scenes that it was not measured on; see `validator_and_played`.

        Raises:
            ConfigurationError: No scene is left, or they lack a sensor that is judged.
            DataError: A file is missing or broken.
        """
        clean = None if self.clean is None else frame_scenes_of(self.clean)
        return validator_and_played(self.validator, self.scenes(), clean)

    def made_planner(self) -> Planner:
        """The planner.

        Raises:
            ConfigurationError: Its arguments do not fit, or what was made of them plans nothing.
        """
        planner: Planner = _made(Kind.PLANNER, self.planner)
        return planner

    def pipeline(self) -> Pipeline:
        """The car, without an attack and without the validator, which changes no drive.

        Raises:
            ConfigurationError: Arguments of a part do not fit.
            DataError: A file, such as the detector's weights, is missing or broken.
        """
        with one_thread():  # As in `_made`.
            return Pipeline(
                self.detector,
                planner=self.planner,
                motion=Motion.named(self.motion),
                score_threshold=self.score_threshold,
            )


def _checked(kind: Kind, what: Any) -> Any:
    """A part that has arguments, made; a bare name or a live part as it is."""
    check(kind, what)
    has_arguments = isinstance(what, Mapping) and set(what) != {"name"}
    return _made(kind, what) if has_arguments else what


def _made(kind: Kind, what: Any) -> Any:
    """The part, which can do what parts of its kind do.

    Raises:
        ConfigurationError: Its arguments do not fit, or what was made of them is no such part.
    """
    with one_thread():  # A forked process would wait forever for the threads of its parent.
        part = make(kind, what)
    check(kind, part)
    return part
