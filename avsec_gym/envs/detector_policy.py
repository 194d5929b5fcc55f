"""`DetectorPolicy`: any detector as an agent with the interface of stable-baselines3."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from avsec_gym.boxes import Boxes3D
from avsec_gym.envs.box_coding import BoxCoding
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Calibration, SensorFrame
from avsec_gym.image_only import check_detector
from avsec_gym.registry import Kind, make
from avsec_gym.scenario.builder import is_obstacle


class DetectorPolicy:
    """A detector that plays `avsec/DetectorBenchmark-v0`.

    Args:
        detector: A name, a dictionary or a live detector; see `avsec_gym.registry.make`.
        environment: The environment that is played.  Detectors that look things up by a frame's
            id (`oracle`, `replayed`) need it; for all others the observation is enough.
        max_boxes: Rows of an action, where no environment is given.

    Raises:
        ConfigurationError: There is no such detector, or it finds 2D boxes alone.

    Example:
        >>> from stable_baselines3.common.evaluation import evaluate_policy
        >>> env = gym.make("avsec/DetectorBenchmark-v0")  # doctest: +SKIP
        >>> evaluate_policy(DetectorPolicy("oracle", env), env)  # doctest: +SKIP
    """

    def __init__(
        self, detector: Any, environment: gym.Env[Any, Any] | None = None, max_boxes: int = 50
    ) -> None:
        self.detector = make(Kind.DETECTOR, detector)
        check_detector(self.detector)
        played: Any = environment
        self._environment: Any = None if environment is None else played.unwrapped
        self.coding = self._environment.coding if self._environment else BoxCoding(max_boxes)

    def predict(
        self,
        observation: dict[str, NDArray[Any]],
        state: Any = None,
        episode_start: Any = None,
        deterministic: bool = True,
    ) -> tuple[NDArray[np.float32], Any]:
        """The action for one observation, or for a batch of them.

        Args:
            observation: One of the environment's, or several with each part stacked along a first
                axis.
            state: The state, which is handed through.
            episode_start: An argument of the interface that is not used: a detector remembers
                nothing.
            deterministic: Detectors always are.

        Returns:
            Actions, shape (8 max_boxes,) or (B, 8 max_boxes), and the state.

        Raises:
            ConfigurationError: Frames of several environments are to be looked up at once.
        """
        single = observation["left"].ndim == 3
        every = {name: part[None] if single else part for name, part in observation.items()}
        count = len(every["left"])
        if self._environment is not None and count > 1:
            raise ConfigurationError(
                "a policy that is given an environment plays that one alone; without it, any number"
            )
        actions = []
        for i in range(count):
            if self._environment is not None:
                frame = self._environment.frame
            else:
                frame = _frame({name: part[i] for name, part in every.items()})
            boxes: Boxes3D = self.detector.detect(frame)
            actions.append(self.coding.encode(boxes[is_obstacle(boxes)]))
        return (actions[0] if single else np.stack(actions)), state


def _frame(observation: dict[str, NDArray[Any]]) -> SensorFrame:
    """An observation as a frame; its scan without the padding."""
    projections = np.zeros((4, 3, 4))
    projections[2:] = observation["calibration"].reshape(2, 3, 4)
    scan = None
    if "points" in observation:
        points = observation["points"].reshape(-1, 4)
        scan = points[(points != 0).any(axis=1)]
    images = {2: observation["left"], 3: observation["right"]}
    # The observation lacks the LiDAR's place: KITTI's axes, at the camera's.
    to_camera = np.array([[0.0, -1, 0, 0], [0, 0, -1, 0], [1, 0, 0, 0]])
    return SensorFrame("observation", Calibration(projections, np.eye(3), to_camera), images, scan)
