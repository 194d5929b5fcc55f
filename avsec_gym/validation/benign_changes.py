"""Changes of one camera that are no attack: what weather, wear and a codec do to its images.

Validators compare cameras with each other, so a change of all of them alike would hide; a change of
one of them is the harder case, and must not be taken for light.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Protocol

import cv2
import numpy as np
from numpy.random import Generator

from avsec_gym.argument_checks import keep_checked, number, whole_number
from avsec_gym.attacks.attack import Seed
from avsec_gym.frame import Image, SensorFrame
from avsec_gym.perception.defences.jpeg import JpegCompression
from avsec_gym.rig import KITTI_SIZE

_GAINS = (0.01, 100.0)
_BLURS = (0.01, 100.0)
_SHIFTS = (-100.0, 100.0)
_DROP_RADII = (8.0, 24.0)
"""Pixels of an image 1242 wide: drops of 2 to 6 mm on a windscreen, out of focus."""
_MOST_DROPS = 10_000


class BenignChange(Protocol):
    """What happens to the images of one camera without an attacker."""

    def changed(self, image: Image, random: Generator) -> Image:
        """The image as the camera delivers it then.

        Args:
            image: Shape (H, W, 3), uint8.
            random: Generator of what the change leaves open.
        """
        ...


@dataclass(frozen=True)
class Gain:
    """An exposure of its own.

    Args:
        factor: Factor of all grey levels; what goes beyond 255 is cut off.
    """

    factor: float = 1.2

    def __post_init__(self) -> None:
        keep_checked(self, {"factor": number("factor", self.factor, *_GAINS)})

    def changed(self, image: Image, random: Generator) -> Image:
        """See `BenignChange`; nothing is drawn."""
        return _whole(image.astype(np.float32) * self.factor)


@dataclass(frozen=True)
class Blur:
    """A lens out of focus.

    Args:
        sigma: Standard deviation of the Gaussian, pixels.
    """

    sigma: float = 1.0

    def __post_init__(self) -> None:
        keep_checked(self, {"sigma": number("sigma", self.sigma, *_BLURS)})

    def changed(self, image: Image, random: Generator) -> Image:
        """See `BenignChange`; nothing is drawn."""
        return np.asarray(cv2.GaussianBlur(image, (0, 0), self.sigma), np.uint8)


@dataclass(frozen=True)
class Jpeg:
    """A camera that compresses what it sends.

    Args:
        quality: Quality of the compression, 1 to 100.
    """

    quality: int = 50

    def __post_init__(self) -> None:
        keep_checked(self, {"quality": whole_number("quality", self.quality, 1, 100)})

    def changed(self, image: Image, random: Generator) -> Image:
        """See `BenignChange`; nothing is drawn."""
        return JpegCompression(self.quality).defend(image, random)


@dataclass(frozen=True)
class RainDrops:
    """Drops on the glass before the camera, so near that they are out of focus.

    A drop gathers light of a wide part of the scene: within it the image is a blur of what lies
    around it, as wide as the drop (after Halimeh and Roser 2009).  Its edge is soft.

    Args:
        drops: How many; their places and radii, 8 to 24 pixels of an image 1242 wide, are drawn.
    """

    drops: int = 20

    def __post_init__(self) -> None:
        keep_checked(self, {"drops": whole_number("drops", self.drops, 0, _MOST_DROPS)})

    def changed(self, image: Image, random: Generator) -> Image:
        """See `BenignChange`."""
        height, width = image.shape[:2]
        scale = width / KITTI_SIZE[0]
        places = random.uniform((0, 0), (width, height), (self.drops, 2))
        radii = scale * random.uniform(*_DROP_RADII, self.drops)
        rows, columns = np.ogrid[:height, :width]
        cover = np.zeros((height, width), np.float32)
        for (u, v), radius in zip(places, radii, strict=True):
            away = np.hypot(rows - v, columns - u)
            # The edge falls off over the outer third of the drop.
            cover = np.maximum(cover, np.clip(3 * (1 - away / radius), 0, 1)).astype(np.float32)
        behind = cv2.GaussianBlur(image, (0, 0), scale * _DROP_RADII[1])
        mixed = image + cover[..., None] * (behind.astype(np.float32) - image)
        return _whole(mixed)


@dataclass(frozen=True)
class Miscalibration:
    """A camera that has moved since it was calibrated: its image stands elsewhere.

    Args:
        rows: How far down the image has moved, pixels.
        columns: How far to the right, pixels.
    """

    rows: float = 1.0
    columns: float = 0.0

    def __post_init__(self) -> None:
        moved = {name: number(name, getattr(self, name), *_SHIFTS) for name in ("rows", "columns")}
        keep_checked(self, moved)

    def changed(self, image: Image, random: Generator) -> Image:
        """See `BenignChange`; nothing is drawn, and what comes in repeats the border."""
        matrix = np.array([[1, 0, self.columns], [0, 1, self.rows]], np.float32)
        size = image.shape[1], image.shape[0]
        moved = cv2.warpAffine(image, matrix, size, borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(moved, np.uint8)


BENIGN_CHANGES: Mapping[str, BenignChange] = MappingProxyType(
    {
        "gain 0.8": Gain(0.8),
        "gain 1.2": Gain(1.2),
        "blur 1 px": Blur(1.0),
        "JPEG 50": Jpeg(50),
        "JPEG 20": Jpeg(20),
        "20 rain drops": RainDrops(20),
        "1 px down": Miscalibration(1.0),
        "1 px to the right": Miscalibration(0.0, 1.0),
    }
)
"""What false alarms are counted under, by name."""


def with_changed_camera(
    frame: SensorFrame, camera: int, change: BenignChange, seed: Seed = 0
) -> SensorFrame:
    """The frame with one camera's image changed.

    Args:
        frame: The frame.
        camera: Number of the camera.
        change: What happens to its image.
        seed: Seed of what the change leaves open.

    Raises:
        DataError: The camera's image is missing or broken.
    """
    random = np.random.default_rng(seed)
    return frame.with_image(camera, change.changed(frame.image(camera), random))


def _whole(levels: np.ndarray) -> Image:
    """Whole grey levels from 0 to 255."""
    return np.clip(np.rint(levels), 0, 255).astype(np.uint8)
