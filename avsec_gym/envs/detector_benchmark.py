"""`avsec/DetectorBenchmark-v0`: a detector whose boxes a car drives by."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from avsec_gym.argument_checks import one_of, whole_number
from avsec_gym.attacks.attack import LEFT
from avsec_gym.attacks.optical_attack import check_attacked
from avsec_gym.boxes import Boxes3D
from avsec_gym.envs.actions import checked_action
from avsec_gym.envs.box_coding import BoxCoding
from avsec_gym.envs.info import episode_info
from avsec_gym.envs.observations import FEATURES, IMAGES, THUMBNAIL, THUMBNAILS, thumbnail
from avsec_gym.envs.one_thread import one_thread
from avsec_gym.envs.parts import parts_of, takes_parts
from avsec_gym.envs.rendering import DrawnEnv
from avsec_gym.envs.reported_boxes import Reported
from avsec_gym.envs.reset_options import reset_options
from avsec_gym.envs.stereo_profile import SIZE, stereo_profile
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Image, SensorFrame
from avsec_gym.geometry import Floats, bird_eye_iou
from avsec_gym.pipeline import Episode, Perception, Pipeline
from avsec_gym.registry import Kind
from avsec_gym.scenario.builder import is_obstacle
from avsec_gym.scenario.frame_scenes import (
    FrameScenes,
    check_frame_scenes,
    frame_scenes_of,
    sensors_of,
)
from avsec_gym.scenario.intention import Intention, intentions_named
from avsec_gym.scenario.scene import Scene
from avsec_gym.validation.compromised_sensors import Untrusted
from avsec_gym.validation.validator import Validation

_MATCHED = 0.5
"""Bird's-eye overlap at which an object counts as found."""
MOST_POINTS = 1_000_000
"""A scan of KITTI's LiDAR has some 120,000."""

Observation = NDArray[np.float32] | dict[str, NDArray[Any]]
_NOTHING = Perception(Boxes3D.empty(), Boxes3D.empty(), None)


@takes_parts(Kind.DETECTOR, detector=None)
class DetectorBenchmarkEnv(DrawnEnv[Observation]):
    """Find the objects around the car; it plans on what you report.

    **Reporting nothing wins often.**  In most of the default scenes no object is in the way: a car
    that believes in none drives safely in 85.4 % of 96 episodes (95 % interval 73.7 to 92.5 %;
    studies/results/detector_ranking.json).  A detector is to be held against that figure.
    `scenarios="mixed_contested"` has only scenes in which such a car drives unsafely.

    ## Description
    The agent is a stereo 3D detector.  It sees one pair of images with its calibration and reports
    boxes; a car plans a lane change, or to keep its lane, among these boxes with A* over motion
    primitives, and its trajectory is checked for collisions with what is really there.
    `DetectorPolicy` makes any detector of this project an agent, so that `evaluate_policy` of
    stable-baselines3 ranks detectors by driving safety, without an attack or under one.  With a
    `validator` before it, the detector gets what the car still trusts after an alarm; where the car
    stops, it does not matter what is reported.

    ## Observation
    `Dict`: `left` and `right`, `Box(0, 255, (H, W, 3), uint8)`, the images of cameras 2 and 3;
    `calibration`, `Box(-1e6, 1e6, (24,), float64)`, their projection matrices P2 and P3, row by
    row; and with `points=M` above 0 `points`, `Box(-1e4, 1e4, (4 M,), float32)`, the LiDAR scan as
    x, y, z (velodyne frame), reflectance, thinned out evenly if there are more, padded with zeros.
    H and W are those of the first frame; larger images lose their right and bottom margins, smaller
    ones are padded with black there.  That is what a detector reads, and the default; an agent of
    stable-baselines3 takes one of the others, since its `MultiInputPolicy` grows with the pixels.
    With `observation="thumbnails"` both images are `Box(0, 255, (48, 160, 3), uint8)`, few enough
    for it, and the calibration is that of these pixels.  With `observation="features"`
    `Box(0, 1, (128,), float32)`: what stands around the car by stereo matching, see
    `avsec_gym.envs.stereo_profile.stereo_profile`.

    ## Action
    `Box(-1, 1, (8 max_boxes,), float32)`: rows of score, x, y, z, h, w, l, ry (camera frame, bottom
    centre), each scaled linearly; a score of 0 or less is no box.  `BoxCoding.encode` and `decode`
    convert.

    ## Reward
    1 if the plan is safe, 0 if it collides or there is none.

    ## Episode end
    Terminated after one step.

    ## Info
    `planned`, `success`, `collision`, `safe`, `cost`, `path_length`, `smallest_distance`,
    `cost_sm1`, `outcome`, `scenario`, `intention`: see `avsec_gym.envs.info.episode_info`;
    `is_success` (safe), `objects` (real obstacles), `found` (those that a reported box overlaps by
    half or more, seen from above), `reported` (boxes above the threshold), `alarm` (of the
    validator).

    ## Arguments
    * The car's parts, see `avsec_gym.envs.parts.Parts`: `scenarios="mixed"`, a default suite of the
      procedural world, made in the cache on first use, or a folder in KITTI's object layout, or a
      dictionary such as `{"source": "/data/kitti/object", "split": "val", "count": 100}`;
      `classifier=None`, `selector=None`, `planner="astar"`, `motion="static"`,
      `score_threshold=0.3`, `road="thesis"`; `validator=None`, with `clean=None` and
      `response="stop"`.
    * `attack=None`: an optical attack, such as `{"name": "facula", "camera": 2}`, or one on what
      detectors see, such as `"thesis_pgd"` or `{"name": "patch", "patch": "FILE"}`; the scenes and
      intentions of a seed are the same with and without it.
    * `detector=None`: the judged detector, which an attack by gradient knows.  Without it, such an
      attack takes the gradients of another one:
      `{"name": "transferred", "attack": "thesis_pgd", "of": "dsgn"}`.
    * `max_boxes=50`: rows of an action, at most 1,000; `points=0`: of the scan, at most 1,000,000.
    * `observation="images"`: or `"thumbnails"`, or `"features"`, see above.
    * `render_mode`: None, `"rgb_array"` or `"human"` (needs the extra `view`).

    `reset(options={"scenario": id, "intention": "left"})` picks a scene.

    ## Versions
    * v0: first.
    """

    title = "avsec/DetectorBenchmark-v0"

    def __init__(
        self,
        *,
        max_boxes: int = 50,
        points: int = 0,
        observation: str = IMAGES,
        render_mode: str | None = None,
        **parts: Any,
    ) -> None:
        super().__init__(render_mode)
        self.coding = BoxCoding(max_boxes)
        self.points = whole_number("points", points, 0, MOST_POINTS)
        self.observation = one_of("observation", observation, (IMAGES, THUMBNAILS, FEATURES))
        self.parts = parts_of(self, parts)
        check_frame_scenes(self.parts.scenarios, self.parts.road)
        check_attacked(self.parts.attack, sensors_of(self.parts.scenarios), "the scenes")
        self.action_space = gym.spaces.Box(-1.0, 1.0, (self.coding.size,), np.float32)
        features = gym.spaces.Box(0.0, 1.0, (SIZE,), np.float32)
        self.observation_space: gym.Space[Any] = (
            features if self.observation == FEATURES else self._sensor_space()
        )
        self._agent = Reported(2 + (self.points > 0))
        self._situation: tuple[Scene, Intention] | None = None
        self._frame: SensorFrame | None = None  # As the sensors deliver it.
        self._shown: SensorFrame | None = None  # As a detector gets it.
        self._perception = _NOTHING
        self._episode: Episode | None = None

    @cached_property
    def pipeline(self) -> Pipeline:
        """The car, in which the agent stands for the detector.

        Raises:
            ConfigurationError: Arguments of a part do not fit.
            DataError: A file, such as the judged detector's weights, is missing or broken.
        """
        return self._car[0]

    @property
    def scenes(self) -> FrameScenes:
        """The scenes that are played."""
        return self._car[1]

    @property
    def frame(self) -> SensorFrame:
        """What a detector gets in the present scene, for those that need all of it.

        Raises:
            ResetNeeded: There is no scene yet.
        """
        if self._shown is None:
            raise gym.error.ResetNeeded("call reset before step")
        return self._shown

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode; ``options`` may pick a ``scenario`` and an ``intention``."""
        super().reset(seed=seed)
        options = reset_options(options)
        scene = self._picked(options.get("scenario"))
        intentions = scene.possible(intentions_named(options.get("intention")))
        # A scene of a contested set is driven with the intentions that it was chosen for.
        chosen = [way for way in intentions if self.scenes.scenes.plays(scene.id, way)]
        intention = (chosen or intentions)[int(self.np_random.integers(len(chosen or intentions)))]
        self._situation = scene, intention
        with one_thread():
            self._frame = self._tampered(scene, intention)
            validator = self.pipeline.validator
            validation = None if validator is None else validator.validate(self._frame)
        self._shown = self._trusted(self._frame, validation)
        self._perception, self._episode = replace(_NOTHING, validation=validation), None
        self.shown()
        return self._observe(), self._info()

    def step(
        self, action: NDArray[np.float32]
    ) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Drive by the reported boxes; the episode is over."""
        scene, intention = self._present
        assert self._frame is not None
        self._agent.boxes = self.coding.decode(checked_action(action, self.coding.size))
        with one_thread():
            self._perception = self.pipeline.perceive(self._frame, self._perception.validation)
        self._episode = self.pipeline.run_episode(scene, self._perception, intention)
        self.shown()
        info = self._info()
        return self._observe(), float(info["safe"]), True, False, info

    def picture(self) -> NDArray[np.uint8] | None:
        """The left image with the believed boxes, above the plan that follows from them."""
        if self._situation is None:
            return None
        from avsec_gym.drawing.detection_picture import detection_picture

        shown = self._episode
        if shown is None:
            shown = self.pipeline.run_episode(self._situation[0], _NOTHING, self._situation[1])
        return detection_picture(self.frame, self._perception.believed, shown)

    @property
    def _present(self) -> tuple[Scene, Intention]:
        if self._situation is None:
            raise gym.error.ResetNeeded("call reset before step")
        return self._situation

    @cached_property
    def _car(self) -> tuple[Pipeline, FrameScenes]:
        return self.parts.car(self._agent)

    def _sensor_space(self) -> gym.spaces.Dict:
        """The sensors' data, at the size of the first frame or as thumbnails."""
        self._size: tuple[int, ...] = (*THUMBNAIL, 3)
        if self.observation == IMAGES:
            scenes = frame_scenes_of(self.parts.scenarios)
            self._size = scenes.frame(scenes.scenes.labelled[0]).image(LEFT).shape
        spaces: dict[str, gym.Space[Any]] = {
            "left": gym.spaces.Box(0, 255, self._size, np.uint8),
            "right": gym.spaces.Box(0, 255, self._size, np.uint8),
            "calibration": gym.spaces.Box(-1e6, 1e6, (24,), np.float64),
        }
        if self.points:
            spaces["points"] = gym.spaces.Box(-1e4, 1e4, (4 * self.points,), np.float32)
        return gym.spaces.Dict(spaces)

    def _picked(self, id: Any) -> Scene:
        labelled = self.scenes.scenes.labelled
        if id is None:
            return labelled[int(self.np_random.integers(len(labelled)))]
        for scene in labelled:
            if scene.id == str(id):
                return scene
        raise ConfigurationError(
            f"{self.scenes.scenes.name} has no scene {id!r}; the first is {labelled[0].id!r}"
        )

    def _tampered(self, scene: Scene, intention: Intention) -> SensorFrame:
        """The frame as the car gets it."""
        frame = self.scenes.frame(scene)
        if self.pipeline.attack is None:
            return frame
        disparity, seed = self.scenes.disparity(scene), int(self.np_random.integers(2**32))
        return self.pipeline.tampered(scene, frame, intention, seed=seed, disparity=disparity)

    def _trusted(self, frame: SensorFrame, validation: Validation | None) -> SensorFrame:
        """What of a frame a detector gets; all of it where the car stops, whatever is found."""
        try:
            trusted = self.pipeline.trusted(frame, validation)
            self._agent.look(trusted)
        except Untrusted:
            return frame
        return trusted

    def _observe(self) -> Observation:
        frame = self.frame
        if self.observation == FEATURES:
            return stereo_profile(frame).astype(np.float32)
        projections = [self._projection(frame, camera).ravel() for camera in (2, 3)]
        result: dict[str, NDArray[Any]] = {
            "left": self._image(frame.image(2)),
            "right": self._image(frame.image(3)),
            "calibration": np.concatenate(projections),
        }
        if self.points:
            every = max(1, -(-len(frame.points) // self.points))
            thinned = frame.points[::every].ravel()
            result["points"] = np.zeros(4 * self.points, np.float32)
            result["points"][: len(thinned)] = thinned
        return result

    def _image(self, image: Image) -> Image:
        """An image as the agent sees it."""
        return thumbnail(image) if self.observation == THUMBNAILS else _fitted(image, self._size)

    def _projection(self, frame: SensorFrame, camera: int) -> Floats:
        """The projection onto the pixels of the image that the agent sees, shape (3, 4)."""
        projection = frame.calibration.projection(camera)
        if self.observation != THUMBNAILS:
            return projection
        height, width = frame.image(camera).shape[:2]
        across, down = THUMBNAIL[1] / width, THUMBNAIL[0] / height
        # Pixels are counted by their centres.
        onto = np.array(
            [[across, 0.0, (across - 1.0) / 2.0], [0.0, down, (down - 1.0) / 2.0], [0.0, 0.0, 1.0]]
        )
        return np.asarray(onto @ projection)

    def _info(self) -> dict[str, Any]:
        scene, intention = self._present
        boxes, reported = scene.boxes[is_obstacle(scene.boxes)], self._perception.believed
        validation = self._perception.validation
        return {
            **episode_info(self._episode, scene.id, intention),
            "is_success": self._episode is not None and self._episode.record.safe,
            "objects": len(boxes),
            "found": _found(boxes, reported),
            "reported": len(reported),
            "alarm": validation is not None and validation.alarm,
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
