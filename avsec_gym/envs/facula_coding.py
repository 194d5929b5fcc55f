"""Where an attacker wants its laser's spot, as an action."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from avsec_gym.attacks.attack import LEFT, RIGHT
from avsec_gym.attacks.facula import Facula
from avsec_gym.envs.actions import LinearScale
from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats

SIZE = 4
"""Camera, column, row, radius."""


@dataclass(frozen=True)
class FaculaCoding:
    """Actions in [-1, 1], scaled linearly to faculae; of images of one size.

    Args:
        size: Height and width of the images, pixels.
        radii: The smallest and the largest, pixels of an image 1242 wide, as `Facula` counts them.
        strength: Of the light, grey levels.

    Raises:
        ConfigurationError: A number that cannot be.
    """

    size: tuple[int, int]
    radii: tuple[float, float]
    strength: float = 255.0

    def __post_init__(self) -> None:
        if np.shape(self.radii) != (2,) or not 0 < self.radii[0] < self.radii[1] < np.inf:
            raise ConfigurationError(
                f"radii are a smallest and a largest, in pixels, got {self.radii}"
            )
        Facula(strength=self.strength)

    def decode(self, action: Floats) -> Facula:
        """The facula that an action names.

        Args:
            action: The right camera if above 0, else the left; column and row of the centre, from
                the left upper to the right lower corner; radius; shape (4,).
        """
        u, v, radius = self._scale.decode(action[1:]).tolist()
        return Facula(RIGHT if action[0] > 0 else LEFT, radius, (u, v), self.strength)

    def encode(self, facula: Facula) -> Floats:
        """The inverse of `decode` for a facula with one radius and a centre, shape (4,)."""
        values = np.array([*(facula.centre or (np.nan, np.nan)), facula.radius], float)
        return np.array([1.0 if facula.camera == RIGHT else -1.0, *self._scale.encode(values)])

    @property
    def _scale(self) -> LinearScale:
        (height, width), (small, large) = self.size, self.radii
        return LinearScale(
            np.array([0.0, 0.0, small]), np.array([width - 1.0, height - 1.0, large])
        )
