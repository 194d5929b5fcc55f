"""`ImageNetworkDetector`: between an image's pixels and a network; Faster R-CNN and YOLOv3 are."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import Protocol, TypeVar

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import Image, SensorFrame
from avsec_gym.perception.detectors.box_selection import SelectedBoxes
from avsec_gym.perception.detectors.image_detector import image_boxes
from avsec_gym.perception.detectors.image_truth import ImageTruth, image_truth
from avsec_gym.perception.detectors.network_detector import NetworkDetector
from avsec_gym.perception.weights.given import Weights

Levels = tuple[float, float, float]
"""The levels of red, green and blue."""


class ImageConfiguration(Protocol):
    """What is needed of a network's configuration here."""

    @property
    def name(self) -> str:
        """The name of the preset."""
        ...

    @property
    def categories(self) -> tuple[str, ...]:
        """What is found."""
        ...

    @property
    def mean(self) -> Levels:
        """Subtracted from grey levels."""
        ...

    @property
    def deviation(self) -> Levels:
        """What the difference is divided by."""
        ...

    def size_for(self, height: int, width: int) -> tuple[int, int]:
        """Height and width that an image of a given size is resized to, pixels."""
        ...


Configuration = TypeVar("Configuration", bound=ImageConfiguration)
Network = TypeVar("Network", bound=nn.Module)


class ImageNetworkDetector(NetworkDetector[Configuration, Network], ABC):
    """A `DifferentiableImageDetector`; see `NetworkDetector`.

    Args:
        configuration: Configuration of the network.
        network: The network's class, which makes one of a configuration.
        weights: The weights, see `give_weights`.
    """

    def __init__(
        self,
        configuration: Configuration,
        network: Callable[[Configuration], Network],
        weights: Weights,
    ) -> None:
        super().__init__(configuration, network, weights, configuration.name)
        self._categories = configuration.categories
        self._levels = configuration.mean, configuration.deviation
        self._size_for = configuration.size_for

    def detect(self, frame: SensorFrame, camera: int = 2) -> Boxes3D:
        """See `ImageDetector`."""
        return self.detect_image(frame.image(camera))

    def detect_image(self, image: Image) -> Boxes3D:
        """See `ImageDetector`."""
        return self.detect_batch(torch.tensor(image).permute(2, 0, 1)[None].float())[0]

    @torch.no_grad()
    def detect_batch(self, images: Tensor) -> list[Boxes3D]:
        """See `DifferentiableImageDetector`; boxes are in the images' own pixels."""
        inputs = self.prepare(images)
        size = np.array([images.shape[3], images.shape[2]] * 2)
        scale = size / np.array([inputs.shape[3], inputs.shape[2]] * 2)
        return [
            image_boxes(
                np.clip((_array(found.boxes) + 0.5) * scale - 0.5, 0, size - 1),
                self.calibration(_array(found.scores)),
                [self._categories[label] for label in found.classes.tolist()],
            )
            for found in self._found(inputs)
        ]

    @abstractmethod
    def losses(self, images: Tensor, truth: Sequence[Boxes3D]) -> dict[str, Tensor]:
        """See `DifferentiableImageDetector`."""

    @abstractmethod
    def _found(self, inputs: Tensor) -> list[SelectedBoxes]:
        """The detections in each of B prepared images, in pixels of these."""

    def prepare(self, images: Tensor) -> Tensor:
        """Images (B, 3, H, W) as the network takes them: scaled, normalised."""
        images = images.to(next(self.network.parameters()))
        size = self._size_for(images.shape[2], images.shape[3])
        if images.shape[2:] != size:
            images = functional.interpolate(
                images, size=size, mode="bilinear", align_corners=False, antialias=True
            )
        mean, deviation = (images.new_tensor(levels)[:, None, None] for levels in self._levels)
        return (images - mean) / deviation

    def truth(self, truth: Sequence[Boxes3D], images: Tensor, inputs: Tensor) -> list[ImageTruth]:
        """What is to be learned of images, in pixels of the prepared ones."""
        scale = inputs.shape[2] / images.shape[2], inputs.shape[3] / images.shape[3]
        return [image_truth(labels, self._categories, scale, inputs) for labels in truth]


def _array(tensor: Tensor) -> np.ndarray:
    return tensor.double().cpu().numpy()
