"""Where an attacker wants its laser's spot, as an action."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from avsec_gym.argument_checks import number, number_range
from avsec_gym.attacks.attack import LEFT, RIGHT
from avsec_gym.attacks.facula import Facula
from avsec_gym.envs.actions import LinearScale
from avsec_gym.geometry import Floats

RADII = (0.1, 10_000.0)
"""Pixels: a spot that no pixel shows, and one that covers the image wherever it is."""
STRENGTHS = (0.1, 2550.0)
"""Grey levels: too little to be seen, and ten times what makes a black pixel white."""


@dataclass(frozen=True)
class FaculaCoding:
    """Actions in [-1, 1], scaled linearly to faculae; of images of one size.

    Args:
        size: Height and width of the images, pixels.
        radii: The smallest and the largest, pixels of an image 1242 wide, as `Facula` counts them;
            within `RADII`.
        strength: Brightness of the light, grey levels; two numbers: the weakest and the strongest;
            within `STRENGTHS`.

    Raises:
        ConfigurationError: A number is out of range, or a range is none.
    """

    size: tuple[int, int]
    radii: tuple[float, float]
    strength: float | tuple[float, float] = 255.0

    def __post_init__(self) -> None:
        is_range = isinstance(self.strength, list | tuple | np.ndarray)
        check = number_range if is_range else number
        object.__setattr__(self, "strength", check("strength", self.strength, *STRENGTHS))
        object.__setattr__(self, "radii", number_range("radii", self.radii, *RADII))

    @property
    def action_size(self) -> int:
        """How many numbers an action has."""
        return 1 + len(self._ranges)

    def decode(self, action: Floats) -> Facula:
        """The facula that an action names.

        Args:
            action: The right camera if above 0, else the left; column and row of the centre, from
                the left upper to the right lower corner; radius; strength, if it is a range;
                shape (action_size,).
        """
        u, v, radius, *strength = self._scale.decode(action[1:]).tolist()
        camera = RIGHT if action[0] > 0 else LEFT
        return Facula(camera, radius, (u, v), *(strength or [self.strength]))

    def encode(self, facula: Facula) -> Floats:
        """The inverse of `decode`; a strength that no action can choose is left out.

        Args:
            facula: A facula with one radius and a centre.
        """
        values = [*(facula.centre or (np.nan, np.nan)), facula.radius, facula.strength]
        scaled = self._scale.encode(np.array(values[: len(self._ranges)], float))
        return np.array([1.0 if facula.camera == RIGHT else -1.0, *scaled])

    @property
    def _ranges(self) -> list[Any]:
        """Of column, row, radius, and of the strength, if it is one."""
        height, width = self.size
        chosen = [self.strength] if isinstance(self.strength, tuple) else []
        return [(0.0, width - 1.0), (0.0, height - 1.0), self.radii, *chosen]

    @property
    def _scale(self) -> LinearScale:
        low, high = np.transpose(self._ranges)
        return LinearScale(low, high)
