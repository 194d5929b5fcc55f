"""Gaussian noise as a defence: what randomised smoothing adds (Cohen et al. 2019)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from avsec_gym.argument_checks import keep_checked, label, number
from avsec_gym.frame import Image


@dataclass(frozen=True)
class GaussianNoise:
    """Independent noise on each channel of each pixel.

    One noisy copy hides what an attack has put there; a vote over several of them
    (`DefendedDetector`'s ``copies``) is randomised smoothing.

    Args:
        strength: Standard deviation, grey levels.
        name: Name of the defence in results.

    Raises:
        ConfigurationError: The strength is not above 0 and up to 255.
    """

    strength: float = 8.0
    name: str = "gaussian_noise"

    def __post_init__(self) -> None:
        strength = number("strength", self.strength, 1e-6, 255.0)
        keep_checked(self, {"strength": strength, "name": label("name", self.name)})

    def defend(self, image: Image, random: Generator) -> Image:
        """See `ImageDefence.defend`."""
        noisy = image + self.strength * random.standard_normal(image.shape, np.float32)
        return np.rint(noisy.clip(0, 255)).astype(np.uint8)
