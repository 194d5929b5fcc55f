"""How vehicles and people move within the tenth of a second that a LiDAR's turn takes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from avsec_gym.geometry import Floats


class PlanarMotion(NamedTuple):
    """Constant speed along the heading and constant turn rate: an arc, or a straight line."""

    speed: float = 0.0
    """Metres a second, negative when reversing."""
    turn_rate: float = 0.0
    """Radians a second to the left."""

    @property
    def stands(self) -> bool:
        """Whether nothing changes."""
        return self.speed == 0.0 and self.turn_rate == 0.0

    def after(self, seconds: ArrayLike) -> tuple[Floats, Floats, Floats]:
        """Metres ahead and to the left, and radians turned, of the inputs' shape.

        Example:
            >>> PlanarMotion(10.0).after(0.05)
            (array(0.5), array(0.), array(0.))
        """
        time = np.asarray(seconds, float)
        angle = self.turn_rate * time
        # The chord of an arc of length v t, half of its angle off the heading.
        chord = self.speed * time * np.sinc(0.5 * angle / np.pi)
        return (
            np.asarray(chord * np.cos(0.5 * angle)),
            np.asarray(chord * np.sin(0.5 * angle)),
            np.asarray(angle),
        )

    def transforms(self, seconds: Floats) -> Floats:
        """From the moved vehicle frame to that at time 0, shape (n, 4, 4).

        Args:
            seconds: Times, shape (n,).
        """
        ahead, left, angle = self.after(seconds)
        result = np.zeros((len(seconds), 4, 4))
        cos, sin = np.cos(angle), np.sin(angle)
        result[:, 0, 0], result[:, 0, 1], result[:, 0, 3] = cos, -sin, ahead
        result[:, 1, 0], result[:, 1, 1], result[:, 1, 3] = sin, cos, left
        result[:, 2, 2] = result[:, 3, 3] = 1.0
        return result
