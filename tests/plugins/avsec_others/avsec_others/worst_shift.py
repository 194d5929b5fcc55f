"""An attack on a detector: the sideways shift of one image that misplaces the cars most."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from avsec_gym.attacks.attack import RIGHT, Budget, Victim
from avsec_gym.frame import SensorFrame

UNSEEN = 100.0
"""Metres by which a car counts as misplaced that the detector does not find at all."""


@dataclass(frozen=True)
class WorstShift:
    """A black-box attack: it looks at detections and labels, never at gradients.

    Args:
        pixels: The largest shift of the right image, to either side.
    """

    name: ClassVar[str] = "worst_shift"
    pixels: int = 2

    @property
    def budget(self) -> Budget:
        """Any pixel may take the value of another one."""
        return Budget(255.0)

    def attack(self, frame: SensorFrame, victim: Victim, seed: object = 0) -> SensorFrame:
        """The worst of all shifts; nothing is drawn from the seed."""
        shifts = range(-self.pixels, self.pixels + 1)
        frames = [_shifted(frame, pixels) for pixels in shifts]
        return max(frames, key=lambda shifted: _misplaced(shifted, victim))


def _shifted(frame: SensorFrame, pixels: int) -> SensorFrame:
    image = frame.image(RIGHT)
    columns = np.arange(image.shape[1]) + pixels
    return frame.with_image(RIGHT, image[:, columns.clip(0, image.shape[1] - 1)])


def _misplaced(frame: SensorFrame, victim: Victim) -> float:
    """How far the nearest detection is from each true object, on average, metres."""
    found = victim.detector.detect(frame).location
    away = np.linalg.norm(victim.truth.location[:, None] - found, axis=-1)
    nearest = away.min(axis=1, initial=UNSEEN)
    return float(nearest.mean()) if len(nearest) else 0.0
