"""JPEG compression as a defence (Dziugaite et al. 2016; Das et al. 2017)."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.random import Generator

from avsec_gym.argument_checks import keep_checked, label, whole_number
from avsec_gym.frame import Image


@dataclass(frozen=True)
class JpegCompression:
    """The image compressed and read again: fine patterns are what JPEG leaves out.

    Args:
        quality: Quality of the compression, 1 to 100.
        name: Name of the defence in results.

    Raises:
        ConfigurationError: The quality is no whole number from 1 to 100.

    Example:
        >>> image = np.random.default_rng(0).integers(0, 256, (16, 16, 3), np.uint8)
        >>> JpegCompression(quality=50).defend(image, np.random.default_rng(0)).shape
        (16, 16, 3)
    """

    quality: int = 75
    name: str = "jpeg"

    def __post_init__(self) -> None:
        quality = whole_number("quality", self.quality, 1, 100)
        keep_checked(self, {"quality": quality, "name": label("name", self.name)})

    def defend(self, image: Image, random: Generator) -> Image:
        """See `ImageDefence.defend`; nothing is drawn."""
        # OpenCV's order of colours matters: JPEG keeps brightness better than colour.
        bgr = np.ascontiguousarray(image[..., ::-1])
        _, coded = cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, self.quality])
        read = np.asarray(cv2.imdecode(coded, cv2.IMREAD_COLOR), np.uint8)
        return np.ascontiguousarray(read[..., ::-1])
