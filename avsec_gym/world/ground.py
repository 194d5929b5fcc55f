"""The height of the land: gentle slopes and swells, level where an actor stands."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel

EASE = 2.0
"""Metres around a pad over which the land comes back to its own height."""
_EDGE = 0.02
"""Metres; what is nearer to a pad is level with it."""


@dataclass(frozen=True, eq=False)
class Ground:
    """A plane with smooth swells, and level pads in it.

    Args:
        plane: Height at the origin (metres) and slopes along x and y.
        swells: Gaussians as x, y, radius, height, shape (n, 4), metres.
        pads: Level rectangles as x, y, heading, length, width, height, shape (n, 6).
    """

    plane: tuple[float, float, float] = (0.0, 0.0, 0.0)
    swells: Floats = field(default_factory=lambda: np.zeros((0, 4)))
    pads: Floats = field(default_factory=lambda: np.zeros((0, 6)))

    def height(self, x: ArrayLike, y: ArrayLike) -> Floats:
        """Height of the ground, metres, of the inputs' shape."""
        x, y = np.asarray(x, float), np.asarray(y, float)
        level = self.plane[0] + self.plane[1] * x + self.plane[2] * y
        for centre_x, centre_y, radius, height in self.swells:
            distance = ((x - centre_x) ** 2 + (y - centre_y) ** 2) / radius**2
            level = level + height * np.exp(-0.5 * distance)
        if len(self.pads) == 0:
            return np.asarray(level)
        x, y, level = np.broadcast_arrays(x, y, level)
        heights = level.flatten()
        _level(x.ravel(), y.ravel(), self.pads, heights)
        return heights.reshape(level.shape)


@kernel()
def _level(x, y, pads, level):  # type: ignore[no-untyped-def]
    """Mix the land's heights with those of pads, which count the more the nearer; in place."""
    for i in range(len(x)):
        weight = 1.0 / EASE**2
        total = weight * level[i]
        for k in range(len(pads)):
            away_x, away_y = x[i] - pads[k, 0], y[i] - pads[k, 1]
            reach = 0.5 * (pads[k, 3] + pads[k, 4]) + EASE
            if abs(away_x) > reach or abs(away_y) > reach:
                continue
            cos, sin = np.cos(pads[k, 2]), np.sin(pads[k, 2])
            ahead = max(abs(cos * away_x + sin * away_y) - 0.5 * pads[k, 3], 0.0)
            aside = max(abs(cos * away_y - sin * away_x) - 0.5 * pads[k, 4], 0.0)
            distance = np.sqrt(ahead**2 + aside**2)
            share = (max(1.0 - distance / EASE, 0.0) / max(distance, _EDGE)) ** 2
            total += share * pads[k, 5]
            weight += share
        level[i] = total / weight
