"""Where an attacker wants its patch, as an action, and the nearest place that can be."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from avsec_gym.attacks.attack import LEFT
from avsec_gym.attacks.patch_placement import (
    PatchPlace,
    PatchRange,
    disparities,
    focal_times_baseline,
)
from avsec_gym.boxes import Boxes3D
from avsec_gym.envs.actions import LinearScale
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Calibration
from avsec_gym.geometry import Floats

SIZE = 5
"""Column, row, disparity, rotation, radius."""
SMALLEST = 0.5
"""The smallest share of a patch's own radius."""

_ROUNDING = 1e-6
"""Pixels between a patch and the right image's edge, so that sums and differences agree on it."""


@dataclass(frozen=True, eq=False)
class PatchCoding:
    """Actions in [-1, 1], scaled linearly to places; of images of one size.

    Args:
        calibration: The cameras' calibration.
        size: Height and width of the images, pixels.
        radius: The patch's radius, pixels; it can be shown half as large, no larger.
        range: The distances that it can stand at, and the angles that it can be turned by.

    Raises:
        ConfigurationError: The images have no room for such a patch.
    """

    calibration: Calibration
    size: tuple[int, int]
    radius: float
    range: PatchRange = field(default_factory=PatchRange)

    def __post_init__(self) -> None:
        self.possible(self.decode(np.ones(SIZE)))

    def decode(self, action: Floats) -> PatchPlace:
        """The place that an action names, possible or not.

        Args:
            action: Column and row from the left upper to the right lower corner, disparity from
                the farthest to the nearest distance, rotation from the largest tilt to the left to
                that to the right, radius from half to whole; shape (5,).
        """
        return PatchPlace(*self._scale.decode(action).tolist())

    def encode(self, place: PatchPlace) -> Floats:
        """The inverse of `decode`, shape (5,)."""
        values = [place.u, place.v, place.disparity, place.rotation, place.radius]
        return self._scale.encode(np.array(values))

    def possible(self, place: PatchPlace, objects: Boxes3D | None = None) -> PatchPlace:
        """The same patch moved to where it can stand.

        As `random_place` draws them: both images show all of it, and it has one of the
        `disparities` that it can have there.

        Args:
            place: The place that was wanted.
            objects: The real objects, which a patch stands in front of.

        Raises:
            ConfigurationError: There is no room.
        """
        height, width = self.size
        projection, radius, range = self.calibration.projection(LEFT), place.radius, self.range
        ground = projection[1, 2] + projection[1, 1] * range.camera_height / range.nearest
        v = self._between(radius, place.v, min(height - 1, ground) - radius)
        least = range.least_disparity(self.calibration, v + radius)
        u = self._between(radius + least + _ROUNDING, place.u, width - 1 - radius)
        least, greatest = disparities(self.calibration, range, u, v, radius, objects)
        disparity = float(min(max(place.disparity, least), greatest))
        return replace(place, u=u, v=v, disparity=disparity)

    @property
    def _scale(self) -> LinearScale:
        height, width = self.size
        seen = focal_times_baseline(self.calibration)
        steepest, smallest = self.range.steepest, SMALLEST * self.radius
        low = [0.0, 0.0, seen / self.range.farthest, -steepest, smallest]
        high = [width - 1.0, height - 1.0, seen / self.range.nearest, steepest, self.radius]
        return LinearScale(np.array(low), np.array(high))

    def _between(self, low: float, value: float, high: float) -> float:
        if low > high:
            raise ConfigurationError(
                f"images of {self.size[1]} x {self.size[0]} pixels have no room for a patch of"
                f" radius {self.radius:g} that both show whole"
            )
        return float(min(max(value, low), high))
