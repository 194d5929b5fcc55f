"""The height of the land: gentle slopes and swells on which everything stands."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from avsec_gym.geometry import Floats


@dataclass(frozen=True, eq=False)
class Ground:
    """A plane with smooth swells.

    Args:
        plane: Height at the origin (metres) and slopes along x and y.
        swells: x, y, radius, height of each, shape (n, 4): Gaussians, metres.
    """

    plane: tuple[float, float, float] = (0.0, 0.0, 0.0)
    swells: Floats = field(default_factory=lambda: np.zeros((0, 4)))

    def height(self, x: ArrayLike, y: ArrayLike) -> Floats:
        """Height of the ground, metres, of the inputs' shape."""
        x, y = np.asarray(x, float), np.asarray(y, float)
        level = self.plane[0] + self.plane[1] * x + self.plane[2] * y
        for centre_x, centre_y, radius, height in self.swells:
            distance = ((x - centre_x) ** 2 + (y - centre_y) ** 2) / radius**2
            level = level + height * np.exp(-0.5 * distance)
        return np.asarray(level)
