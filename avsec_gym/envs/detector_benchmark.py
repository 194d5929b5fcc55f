"""`avsec/DetectorBenchmark-v0`: a detector whose boxes a car drives by."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from avsec_gym.argument_checks import whole_number
from avsec_gym.attacks.optical_attack import OpticalAttack
from avsec_gym.boxes import Boxes3D
from avsec_gym.envs.actions import checked_action
from avsec_gym.envs.box_coding import BoxCoding
from avsec_gym.envs.info import drive_info
from avsec_gym.envs.parts import Parts
from avsec_gym.envs.rendering import DrawnEnv
from avsec_gym.envs.reset_options import reset_options
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Image, SensorFrame
from avsec_gym.geometry import bird_eye_iou
from avsec_gym.pipeline import Episode, run_episode
from avsec_gym.registry import Kind
from avsec_gym.scenario.builder import is_obstacle
from avsec_gym.scenario.intention import Intention, intentions_named
from avsec_gym.scenario.scene import Motion, Scene

_MATCHED = 0.5
"""Bird's-eye overlap at which an object counts as found."""
MOST_POINTS = 1_000_000
"""A scan of KITTI's LiDAR has some 120,000."""

Observation = dict[str, NDArray[Any]]


class DetectorBenchmarkEnv(DrawnEnv[Observation]):
    """Find the objects around the car; it plans on what you report.

    ## Description
    The agent is a stereo 3D detector.  It sees one pair of images with its calibration and reports
    boxes; a car plans a lane change, or to keep its lane, among these boxes with A* over motion
    primitives, and its trajectory is checked for collisions with what is really there.
    `DetectorPolicy` makes any detector of this project an agent, so that `evaluate_policy` of
    stable-baselines3 ranks detectors by driving safety.

    ## Observation
    `Dict`: `left` and `right`, `Box(0, 255, (H, W, 3), uint8)`, the images of cameras 2 and 3;
    `calibration`, `Box(-1e6, 1e6, (24,), float64)`, their projection matrices P2 and P3, row by
    row; and with `points=M` above 0 `points`, `Box(-1e4, 1e4, (4 M,), float32)`, the LiDAR scan as
    x, y, z (velodyne frame), reflectance, thinned out evenly if there are more, padded with zeros.
    H and W are those of the first frame; larger images lose their right and bottom margins,
    smaller ones are padded with black there.

    ## Action
    `Box(-1, 1, (8 max_boxes,), float32)`: rows of score, x, y, z, h, w, l, ry (camera frame, bottom
    centre), each scaled linearly; a score of 0 or less is no box.  `BoxCoding.encode` and `decode`
    convert.

    ## Reward
    1 if the drive is safe, 0 if it collides or no plan is found.

    ## Episode end
    Terminated after one step.

    ## Info
    `planned`, `collision`, `safe`, `is_success` (safe), `cost` (planned time in s, nan if
    unplanned), `outcome` (`safe`, `collision`, `unplanned`; `reset` at reset), `scenario`,
    `intention`, `objects` (real obstacles), `found` (those that a reported box overlaps by half
    or more, seen from above), `reported` (boxes above the threshold).

    ## Arguments
    * `scenarios="mixed"`: a default suite of the procedural world (`mixed`, `street`, `highway`,
      made in the cache on first use); a folder in KITTI's object layout; or a dictionary such as
      `{"source": "/data/kitti/object", "split": "val", "count": 100}`.
    * `planner="astar"`
    * `motion="static"`: the planner takes everything to stand; `"truth"`: it knows how the real
      objects behind the boxes move.
    * `score_threshold=0.3`: boxes below it, in [0, 1], are not planned on.
    * `max_boxes=50`: rows of an action, at most 1,000; `points=0`: of the scan, at most 1,000,000.
    * `attack=None`: an optical attack on the sensors, such as `{"name": "facula", "camera": 2}`;
      the scenes and intentions of a seed are the same with and without it.
    * `render_mode`: None, `"rgb_array"` or `"human"` (needs the extra `view`).

    `reset(options={"scenario": id, "intention": "left"})` picks a scene.

    ## Versions
    * v0: first.
    """

    title = "avsec/DetectorBenchmark-v0"

    def __init__(
        self,
        scenarios: Any = "mixed",
        planner: Any = "astar",
        motion: Motion | str = Motion.STATIC,
        score_threshold: float = 0.3,
        max_boxes: int = 50,
        points: int = 0,
        attack: Any = None,
        render_mode: str | None = None,
    ) -> None:
        super().__init__(render_mode)
        self.coding = BoxCoding(max_boxes)
        self.points = whole_number("points", points, 0, MOST_POINTS)
        parts = Parts(
            scenarios, None, planner, motion, score_threshold, attack=attack, agent=Kind.DETECTOR
        )
        # The planner first: a slip is reported before minutes in which a suite is made.
        self.motion, self.planner = Motion.named(parts.motion), parts.made_planner()
        self.attack: OpticalAttack | None = parts.attack
        self.scenes = parts.scenes()
        self.score_threshold = parts.score_threshold
        self._labelled = self.scenes.scenes.labelled
        self._size = self.scenes.frame(self._labelled[0]).image(2).shape
        self.action_space = gym.spaces.Box(-1.0, 1.0, (self.coding.size,), np.float32)
        spaces: dict[str, gym.Space[Any]] = {
            "left": gym.spaces.Box(0, 255, self._size, np.uint8),
            "right": gym.spaces.Box(0, 255, self._size, np.uint8),
            "calibration": gym.spaces.Box(-1e6, 1e6, (24,), np.float64),
        }
        if self.points:
            spaces["points"] = gym.spaces.Box(-1e4, 1e4, (4 * self.points,), np.float32)
        self.observation_space = gym.spaces.Dict(spaces)  # type: ignore[assignment]
        self._scene: Scene | None = None
        self._frame: SensorFrame | None = None
        self._intention = Intention.STRAIGHT
        self._reported = Boxes3D.empty()
        self._drive: Episode | None = None

    @property
    def frame(self) -> SensorFrame:
        """What the sensors deliver in the present scene, for detectors that need all of it.

        Raises:
            ResetNeeded: There is no scene yet.
        """
        if self._frame is None:
            raise gym.error.ResetNeeded("call reset before step")
        return self._frame

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode; ``options`` may pick a ``scenario`` and an ``intention``."""
        super().reset(seed=seed)
        options = reset_options(options)
        intentions = intentions_named(options.get("intention"))
        self._scene = self._picked(options.get("scenario"))
        self._intention = intentions[int(self.np_random.integers(len(intentions)))]
        self._frame = self._seen(self.scenes.frame(self._scene))
        self._reported, self._drive = Boxes3D.empty(), None
        self.shown()
        return self._observe(), self._info()

    def step(
        self, action: NDArray[np.float32]
    ) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Episode by the reported boxes; the episode is over."""
        scene = self._present
        reported = self.coding.decode(checked_action(action, self.coding.size))
        self._reported = reported = reported[reported.score >= self.score_threshold]
        self._drive = run_episode(
            scene, self._intention, reported, motion=self.motion, planner=self.planner
        )
        self.shown()
        info = self._info()
        return self._observe(), float(info["safe"]), True, False, info

    def picture(self) -> NDArray[np.uint8] | None:
        """The left image with the believed boxes, above the drive that follows from them."""
        if self._scene is None:
            return None
        from avsec_gym.drawing.detection_picture import detection_picture

        believed = self._reported
        shown = self._drive or run_episode(
            self._scene, self._intention, believed, planner=self.planner
        )
        return detection_picture(self.frame, believed, shown)

    @property
    def _present(self) -> Scene:
        if self._scene is None:
            raise gym.error.ResetNeeded("call reset before step")
        return self._scene

    def _picked(self, id: Any) -> Scene:
        if id is None:
            return self._labelled[int(self.np_random.integers(len(self._labelled)))]
        for scene in self._labelled:
            if scene.id == str(id):
                return scene
        raise ConfigurationError(
            f"{self.scenes.scenes.name} has no scene {id!r}; the first is {self._labelled[0].id!r}"
        )

    def _seen(self, frame: SensorFrame) -> SensorFrame:
        """The frame as the car gets it."""
        if self.attack is None:
            return frame
        return self.attack.attack(frame, int(self.np_random.integers(2**32))).frame

    def _observe(self) -> Observation:
        frame = self.frame
        projections = [frame.calibration.projection(camera).ravel() for camera in (2, 3)]
        result: Observation = {
            "left": _fitted(frame.image(2), self._size),
            "right": _fitted(frame.image(3), self._size),
            "calibration": np.concatenate(projections),
        }
        if self.points:
            every = max(1, -(-len(frame.points) // self.points))
            thinned = frame.points[::every].ravel()
            result["points"] = np.zeros(4 * self.points, np.float32)
            result["points"][: len(thinned)] = thinned
        return result

    def _info(self) -> dict[str, Any]:
        record = self._drive.record if self._drive is not None else None
        boxes, reported = self._present.boxes[is_obstacle(self._present.boxes)], self._reported
        return {
            **drive_info(self._drive, self._present.id, self._intention),
            "is_success": record is not None and record.safe,
            "objects": len(boxes),
            "found": _found(boxes, reported),
            "reported": len(reported),
        }


def _found(boxes: Boxes3D, reported: Boxes3D) -> int:
    if not len(boxes) or not len(reported):
        return 0
    overlap = bird_eye_iou(
        boxes.poses,
        np.stack([boxes.length, boxes.width], axis=1),
        reported.poses,
        np.stack([reported.length, reported.width], axis=1),
    )
    return int((overlap.max(axis=1) >= _MATCHED).sum())


def _fitted(image: Image, size: tuple[int, ...]) -> Image:
    """A copy of the upper left part in the size, black where the image has nothing."""
    result = np.zeros(size, np.uint8)
    height, width = min(size[0], image.shape[0]), min(size[1], image.shape[1])
    result[:height, :width] = image[:height, :width]
    return result
