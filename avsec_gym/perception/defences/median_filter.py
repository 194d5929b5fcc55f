"""A median filter as a defence: the second of feature squeezing's two (Xu et al. 2018)."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.random import Generator

from avsec_gym.argument_checks import keep_checked, label, whole_number
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Image


@dataclass(frozen=True)
class MedianFilter:
    """Each channel of each pixel replaced by the median of the pixels around it.

    Args:
        width: Width of the square whose median is taken, pixels, odd.
        name: Name of the defence in results.

    Raises:
        ConfigurationError: The width is even, or not from 3 to 31.
    """

    width: int = 3
    name: str = "median_filter"

    def __post_init__(self) -> None:
        width = whole_number("width", self.width, 3, 31)
        if width % 2 == 0:
            raise ConfigurationError(f"width takes an odd number, such as {width + 1}, got {width}")
        keep_checked(self, {"width": width, "name": label("name", self.name)})

    def defend(self, image: Image, random: Generator) -> Image:
        """See `ImageDefence.defend`; nothing is drawn."""
        return np.asarray(cv2.medianBlur(np.ascontiguousarray(image), self.width), np.uint8)
