"""`S`, the driving-constraint selector: street or highway, from the images (thesis, 5.3.1).

The thesis writes ``(s_0, r, d) = S(I_l, I_r)``: start state, speed range and dynamics.  All three
follow from the road type alone, by `avsec_gym.scenario.constraints.driving_constraints`, which
belongs to the scenario; here is what has to be learned::

    constraints = driving_constraints(DrivingConstraintSelector().select(frame))
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from avsec_gym.argument_checks import camera_number, shown
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Image, SensorFrame
from avsec_gym.perception.presets import chosen_configuration
from avsec_gym.perception.weights.given import SHIPPED, Weights, check_weights, give_weights
from avsec_gym.road_type import RoadType

ROAD_TYPES = (RoadType.STREET, RoadType.HIGHWAY)
"""Road types in the order of the network's evidence."""


@dataclass(frozen=True)
class RoadTypeConfiguration:
    """What the network is made of.

    Raises:
        ConfigurationError: Numbers that cannot be, or another preset.
    """

    channels: tuple[int, int, int, int, int] = (16, 32, 48, 64, 64)
    """Channels of the five convolutions."""
    input_size: tuple[int, int] = (96, 320)
    """Height and width to which images are reduced, multiples of 16."""
    dropout: float = 0.5
    """Dropout before the fully connected layer."""

    def __post_init__(self) -> None:
        if len(self.channels) != 5 or min(self.channels) < 1 or not 0 <= self.dropout < 1:
            raise ConfigurationError(f"five convolutions and a share of dropout, got {self}")
        if min(self.input_size) < 16 or any(side % 16 for side in self.input_size):
            raise ConfigurationError(f"input sides are multiples of 16, got {self.input_size}")

    @classmethod
    def preset(cls, name: str) -> RoadTypeConfiguration:
        """The thesis gives no numbers; ``small`` is what was trained here."""
        if name != "small":
            raise ConfigurationError(f"there is no road type preset {shown(name)}; known: small")
        return cls()


class RoadTypeNetwork(nn.Module):
    """Five convolutions joined by max pooling, a fully connected layer with dropout; all ReLU.

    Args:
        configuration: The configuration of the layers.
    """

    def __init__(self, configuration: RoadTypeConfiguration) -> None:
        super().__init__()
        channels = (3, *configuration.channels)
        layers: list[nn.Module] = []
        for number, (into, out) in enumerate(pairwise(channels)):
            if number:
                layers.append(nn.MaxPool2d(2))
            layers += [nn.Conv2d(into, out, 3, padding=1), nn.ReLU(inplace=True)]
        self.features = nn.Sequential(*layers)
        height, width = (side // 16 for side in configuration.input_size)
        self.dropout = nn.Dropout(configuration.dropout)
        self.decision = nn.Linear(channels[-1] * height * width, len(ROAD_TYPES))
        for module in self.modules():
            if isinstance(module, nn.Conv2d):
                nn.init.kaiming_normal_(module.weight, nonlinearity="relu")
        # Evidence is never negative; where both were 0, nothing could be learned any more.
        nn.init.normal_(self.decision.weight, std=0.01)
        nn.init.constant_(self.decision.bias, 2.0)

    def forward(self, images: Tensor) -> Tensor:
        """Evidence of street and highway, shape (N, 2), 0 or more; a softmax makes probabilities.

        Args:
            images: Grey levels 0..255, shape (N, 3, H, W).
        """
        x = self.features((images - 128.0) / 64.0)
        evidence: Tensor = self.decision(self.dropout(torch.flatten(x, 1)))
        return torch.relu(evidence)


class DrivingConstraintSelector:
    """S: the road type of a frame.

    The network sees each image of the pair by itself; what it finds in both is added.  One image
    is enough, as in the lists of the thesis' authors.

    Args:
        configuration: The configuration of the network, or a preset's name.
        weights: A file, a ``state_dict``, ``shipped``, or None for random ones; see `give_weights`.
        cameras: The cameras whose images are looked at, as far as the frame has them.

    Raises:
        ConfigurationError: Another preset, or a `state_dict` of another network.
        DataError: The file cannot be read, or is of another network.
    """

    name = "road_type"

    def __init__(
        self,
        configuration: RoadTypeConfiguration | str = "small",
        weights: Weights = SHIPPED,
        cameras: tuple[int, ...] = (2, 3),
    ) -> None:
        configuration, _ = chosen_configuration(RoadTypeConfiguration, configuration)
        if not isinstance(cameras, list | tuple) or not cameras:
            raise ConfigurationError(
                f"cameras takes cameras' numbers such as (2, 3), got {shown(cameras)}"
            )
        self.configuration = configuration
        self.cameras = tuple(camera_number("cameras", camera) for camera in cameras)
        check_weights(weights, f"{self.name}_small")
        self.network = RoadTypeNetwork(configuration)
        give_weights(self.network, weights, f"{self.name}_small")

    def select(self, frame: SensorFrame) -> RoadType:
        """The likelier road type; in doubt a street, on which one drives slowly.

        Raises:
            DataError: The frame has no image of these cameras, or a broken one.
        """
        return ROAD_TYPES[int(self.highway_probability(frame) > 0.5)]

    def highway_probability(self, frame: SensorFrame) -> float:
        """How surely the road is a highway; see `select`."""
        there = [camera for camera in self.cameras if camera in frame.images]
        images = [frame.image(camera) for camera in there or self.cameras[:1]]
        size = self.configuration.input_size
        small = np.stack([reduced_image(image, size) for image in images])
        with torch.no_grad():
            evidence = self.network(torch.from_numpy(small).permute(0, 3, 1, 2).float())
        return float(torch.softmax(evidence.mean(dim=0), dim=0)[1])


def reduced_image(image: Image, size: tuple[int, int]) -> NDArray[np.uint8]:
    """An image as the network sees it: of this height and width, shape (H, W, 3)."""
    import cv2

    return np.asarray(cv2.resize(image, size[::-1], interpolation=cv2.INTER_AREA))
