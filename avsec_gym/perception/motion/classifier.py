"""`MovingObjectClassifier`: decides of detected objects whether they move."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from avsec_gym.argument_checks import camera_number, number
from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats
from avsec_gym.perception.motion.crops import Crops, current_crops, earlier_crops, object_regions
from avsec_gym.perception.motion.displacement import likeliest_ways
from avsec_gym.perception.motion.ego_motion import ego_motion
from avsec_gym.perception.motion.network import CropBatch, MotionConfiguration, MotionNetwork
from avsec_gym.perception.presets import chosen_configuration
from avsec_gym.perception.weights.given import SHIPPED, Weights, check_weights, give_weights

_THRESHOLD = 0.5
_SINGLE_THRESHOLD = 0.9
"""The threshold for single crops: of 63 real cars that stood, single crops gave 20 a probability
above 0.5."""


@dataclass(frozen=True, eq=False)
class Neighbour:
    """An earlier frame, and how the ego vehicle has moved since.

    Args:
        frame: The earlier frame, with a left image.
        motion: The ego motion between the two, see `ego_motion`, shape (4, 4).
    """

    frame: SensorFrame
    motion: Floats


@dataclass(frozen=True, eq=False)
class ObjectCrops:
    """What a classifier sees of N objects.

    Args:
        now: The crops of the frame itself, shape (N, H, W, 3).
        before: The same places in an earlier frame, if the objects stood, and if they drove; shape
            (N, 2, H, W, 3), None where no earlier frame is of use.
    """

    now: Crops
    before: NDArray[np.uint8] | None


class MovingObjectClassifier:
    """b> = C(b, I_l, I_r): which objects move, from a frame and the frames before it.

    The `small` network compares an object's crop with the earliest of the frame's `previous`
    ones, stabilised by the ego motion that the images show, under two stories: that the object
    stood, and that it drove the way along its heading that explains the earlier image best.
    Where there is no such frame, or the images do not show it (`neighbour_of` finds None), it has
    the single crop, as the `vgg16` network always does, and can but guess from looks and place:
    then it abstains, which means that the object stands, unless it is very sure.

    Args:
        configuration: The configuration of the network, or a preset's name.
        weights: The weights of the network: a file, a ``state_dict``, ``shipped``, or None for
            random ones; see `give_weights`.
        threshold: The least probability of an object that is classified as moving.
        single_threshold: The same where a network that compares two frames has but one.
        left: The reference camera.
        right: The other camera.

    Raises:
        ConfigurationError: Another preset, or a `state_dict` of another network.
        DataError: The file cannot be read, or is of another network.

    Source:
        Thesis, section 5.4.1; the stabilised neighbour is this project's.
    """

    name = "motion"

    def __init__(
        self,
        configuration: MotionConfiguration | str = "small",
        weights: Weights = SHIPPED,
        threshold: float = _THRESHOLD,
        single_threshold: float = _SINGLE_THRESHOLD,
        left: int = 2,
        right: int = 3,
    ) -> None:
        configuration, preset = chosen_configuration(MotionConfiguration, configuration)
        self.configuration = configuration
        self.threshold = number("threshold", threshold, 0.0, 1.0)
        self.single_threshold = number("single_threshold", single_threshold, 0.0, 1.0)
        self.left, self.right = camera_number("left", left), camera_number("right", right)
        check_weights(weights, f"{self.name}_{preset}")
        self.network = MotionNetwork(configuration)
        give_weights(self.network, weights, f"{self.name}_{preset}")

    def classify(self, boxes: Boxes3D, frame: SensorFrame) -> Boxes3D:
        """The same boxes with `moving` set.

        Args:
            boxes: Objects of the frame.
            frame: The frame, with an image of the left camera; the right one and `previous` help.

        Raises:
            DataError: The left image is missing or broken.
        """
        if not len(boxes):
            return replace(boxes, moving=np.zeros(0, bool))
        crops = self.crops(boxes, frame)
        is_guess = self.configuration.neighbour and crops.before is None
        threshold = self.single_threshold if is_guess else self.threshold
        return replace(boxes, moving=self.probabilities_of(crops) >= threshold)

    def probabilities(self, boxes: Boxes3D, frame: SensorFrame) -> Floats:
        """How surely each object moves, shape (N,); see `classify`."""
        if not len(boxes):
            return np.zeros(0)
        return self.probabilities_of(self.crops(boxes, frame))

    def probabilities_of(self, crops: ObjectCrops) -> Floats:
        """How surely the objects of crops move, shape (N,)."""
        with torch.no_grad():
            logits = self.network(crop_batch(crops))
        return np.asarray(torch.sigmoid(logits).double().numpy())

    def crops(self, boxes: Boxes3D, frame: SensorFrame) -> ObjectCrops:
        """What the network sees of objects."""
        neighbour = None
        if self.configuration.neighbour:
            neighbour = neighbour_of(frame, boxes, self.left, self.right)
        return object_crops(boxes, frame, neighbour, self.configuration.crop, left=self.left)


def vgg16_classifier(
    weights: Weights,
    threshold: float = _THRESHOLD,
    single_threshold: float = _SINGLE_THRESHOLD,
    left: int = 2,
    right: int = 3,
) -> MovingObjectClassifier:
    """The thesis' network as a classifier; no weights of it come with the package.

    Args:
        weights: Its weights; see `MovingObjectClassifier`, as for all others.
        threshold: The least probability of an object that is classified as moving.
        single_threshold: Not used: the network has single crops alone.
        left: The reference camera.
        right: The other camera.

    Raises:
        ConfigurationError: The weights are of another network.
        DataError: The file cannot be read, or is of another network.
    """
    return MovingObjectClassifier("vgg16", weights, threshold, single_threshold, left, right)


def neighbour_of(
    frame: SensorFrame, boxes: Boxes3D, left: int = 2, right: int = 3
) -> Neighbour | None:
    """The earliest of a frame's previous ones from which the ego motion can be found, if any."""
    for earlier in reversed(frame.previous):
        motion = ego_motion(frame, earlier, boxes.box2d, left, right)
        if motion is not None:
            return Neighbour(earlier, motion)
    return None


def object_crops(
    boxes: Boxes3D,
    frame: SensorFrame,
    neighbour: Neighbour | None,
    size: tuple[int, int],
    *,
    margin: int = 0,
    left: int = 2,
) -> ObjectCrops:
    """Crops of objects, now and in an earlier frame.

    Args:
        boxes: N objects.
        frame: The current one.
        neighbour: The earlier frame.
        size: Height and width of the crops.
        margin: Pixels by which the crops are larger on every side, at the same scale.
        left: Reference camera.

    Raises:
        DataError: The left image is missing or broken.
    """
    image, projection = frame.image(left), frame.calibration.projection(left)
    regions = object_regions(boxes, projection, image.shape[:2])
    more = margin * (regions[:, 2:] - regions[:, :2]) / np.array(size[::-1])
    regions = regions + np.concatenate([-more, more], axis=1)
    size = (size[0] + 2 * margin, size[1] + 2 * margin)
    now = current_crops(image, regions, size)
    if neighbour is None:
        return ObjectCrops(now, None)
    there = neighbour.frame.image(left)
    motion = neighbour.motion
    ways = likeliest_ways(image, there, regions, boxes, projection, motion)
    stories = [
        earlier_crops(there, regions, size, boxes, projection, motion, driven)
        for driven in (None, ways)
    ]
    return ObjectCrops(now, np.stack(stories, axis=1))


def crop_batch(crops: ObjectCrops) -> CropBatch:
    """Crops as the network takes them."""
    now = _tensor(crops.now)
    known = torch.full((len(now),), crops.before is not None)
    if crops.before is None:
        return CropBatch(now, now[:, None].expand(-1, 2, -1, -1, -1), known)
    return CropBatch(now, _tensor(crops.before), known)


def _tensor(crops: NDArray[np.uint8]) -> Tensor:
    return torch.from_numpy(crops).movedim(-1, -3).float()
