"""The parts of the pipeline that an environment's agent does not play, checked and made.

An environment is the pipeline with one part taken out, which the agent plays.  The others are
keyword arguments with the same names, defaults and meaning in every environment: names, JSON-able
dictionaries or live objects.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from avsec_gym.envs.game_validator import check_validator, validator_and_played
from avsec_gym.errors import ConfigurationError
from avsec_gym.pipeline import Pipeline
from avsec_gym.planners.planner import Planner
from avsec_gym.registry import Kind, check, make
from avsec_gym.scenario.frame_scenes import FrameScenes, check_frame_scenes, frame_scenes_of
from avsec_gym.scenario.scene import Motion

if TYPE_CHECKING:  # OpenCV is loaded where somebody validates, not before.
    from avsec_gym.validation.validator import Validator


@dataclass(frozen=True, eq=False)
class Parts:
    """What an environment on sensor data is made of, beside its agent.

    A mistyped name is refused at once; nothing is loaded, made or measured before it is asked for.

    Args:
        scenarios: Scenes with sensor data, as of `frame_scenes_of`.
        detector: Finds objects in the sensor data; not used where the agent does.
        planner: Plans the drive among the detected objects.
        motion: What the planner knows of motion; there is no classifier.
        score_threshold: Detections of a lower score are not planned on, in [0, 1].
        validator: Looks for attacks on the sensors, see `validator_and_played`; None: none.
        clean: Scenes that thresholds of the validator are measured on; None: the first half of the
            scenarios.
        agent: The part that the agent plays.

    Raises:
        ConfigurationError: A name is unknown, or a number is out of range.
        DataError: A folder of scenes is missing.
    """

    scenarios: Any = "mixed"
    detector: Any = "dsgn"
    planner: Any = "astar"
    motion: Motion | str = Motion.STATIC
    score_threshold: float = 0.3
    validator: Any = None
    clean: Any = None
    agent: Kind = Kind.ATTACK

    def __post_init__(self) -> None:
        if not 0 <= self.score_threshold <= 1:
            raise ConfigurationError(f"a score threshold is in [0, 1], got {self.score_threshold}")
        if self.agent != Kind.DETECTOR:
            check(Kind.DETECTOR, self.detector)
        check(Kind.PLANNER, self.planner)
        check_validator(self.validator, self.clean)
        check_frame_scenes(self.scenarios)
        object.__setattr__(self, "motion", Motion.without_classifier(self.motion))

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
        planner: Planner = make(Kind.PLANNER, self.planner)
        check(Kind.PLANNER, planner)
        return planner

    def pipeline(self) -> Pipeline:
        """The car, without an attack and without the validator, which changes no drive.

        Raises:
            ConfigurationError: Arguments of a part do not fit.
            DataError: A file, such as the detector's weights, is missing or broken.
        """
        return Pipeline(
            self.detector,
            planner=self.planner,
            motion=Motion.named(self.motion),
            score_threshold=self.score_threshold,
        )
