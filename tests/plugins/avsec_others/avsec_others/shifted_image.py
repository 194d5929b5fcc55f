"""An attack that moves the image of one camera sideways, which changes every stereo depth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from avsec_gym.attacks.optical_attack import TamperedFrame
from avsec_gym.frame import SensorFrame
from avsec_gym.sensor_system import Sensor


@dataclass(frozen=True)
class ShiftedImage:
    """Every row of an image begins some pixels earlier; its last column fills the gap.

    With the camera on the right, disparities d become d + pixels: what is at z = f b / d seems to
    be at f b / (d + pixels), nearer for positive numbers, farther away for negative ones.

    Args:
        pixels: To the left; negative numbers shift to the right.
        camera: The attacked camera.
    """

    name: ClassVar[str] = "shifted_image"
    pixels: int = 4
    camera: int = 3

    @property
    def sensors(self) -> frozenset[Sensor]:
        """The attacked camera."""
        return frozenset({self.camera})

    def attack(self, frame: SensorFrame, seed: object = 0) -> TamperedFrame:
        """The frame with the shifted image; nothing is drawn from the seed."""
        image = frame.image(self.camera)
        columns = np.arange(image.shape[1]) + self.pixels
        shifted = image[:, columns.clip(0, image.shape[1] - 1)]
        changed = (shifted != image).any(axis=2)
        tampered = frame.with_image(self.camera, shifted)
        return TamperedFrame(tampered, pixels={self.camera: changed})
