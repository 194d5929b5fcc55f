"""Fewer grey levels as a defence: the first of feature squeezing's two (Xu et al. 2018)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from avsec_gym.argument_checks import keep_checked, label, whole_number
from avsec_gym.frame import Image


@dataclass(frozen=True)
class BitDepth:
    """Each channel rounded to the nearest of 2^bits levels, from black to white.

    Args:
        bits: Bits of a channel that are kept, 1 to 8.
        name: Name of the defence in results.

    Raises:
        ConfigurationError: The bits are no whole number from 1 to 8.

    Example:
        >>> image = np.array([[[0, 100, 255]]], np.uint8)
        >>> BitDepth(bits=1).defend(image, np.random.default_rng(0)).tolist()
        [[[0, 0, 255]]]
    """

    bits: int = 4
    name: str = "bit_depth"

    def __post_init__(self) -> None:
        bits = whole_number("bits", self.bits, 1, 8)
        keep_checked(self, {"bits": bits, "name": label("name", self.name)})

    def defend(self, image: Image, random: Generator) -> Image:
        """See `ImageDefence.defend`; nothing is drawn."""
        steps = 2**self.bits - 1
        levels = np.rint(np.arange(256) * (steps / 255)) * (255 / steps)
        return np.rint(levels).astype(np.uint8)[image]
