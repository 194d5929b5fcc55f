"""How complex the texture of a region is: what the thesis holds to decide where ghosts appear."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from avsec_gym.attacks.side_area import Mask
from avsec_gym.frame import Image

_WINDOW = 7
"""The side of the window, pixels."""


@dataclass(frozen=True)
class TextureComplexity:
    """How busy the luminance of a region is; NaN without pixels.

    Args:
        gradient: Root mean square of its gradient, grey levels a pixel.
        deviation: Mean standard deviation in windows of 7 x 7 pixels, grey levels.
        pixels: Number of pixels that were measured.
    """

    gradient: float
    deviation: float
    pixels: int


def texture_complexity(image: Image, region: Mask) -> TextureComplexity:
    """Measure a region (thesis, section 5.5.1: the road's texture is more regular than its side's).

    Args:
        image: Image in red, green, blue, shape (H, W, 3).
        region: Whether each pixel is measured, shape (H, W); windows that reach beyond it are left
            out, so that its outline does not count as texture.
    """
    window = np.ones((_WINDOW, _WINDOW), np.uint8)
    inside = cv2.erode(region.astype(np.uint8), window, borderValue=0) > 0
    if not inside.any():
        return TextureComplexity(np.nan, np.nan, 0)
    bright = luminance(image)
    down, across = np.gradient(bright)
    mean, square = (cv2.blur(each, (_WINDOW, _WINDOW)) for each in (bright, bright**2))
    deviation = np.sqrt(np.maximum(square - mean**2, 0.0))
    gradient = np.sqrt(np.square(np.hypot(down, across)[inside]).mean())
    return TextureComplexity(float(gradient), float(deviation[inside].mean()), int(inside.sum()))


def luminance(image: Image | NDArray[np.float32]) -> NDArray[np.float64]:
    """The luminance of red, green and blue, grey levels, shape (H, W)."""
    return np.asarray(image @ np.array([0.299, 0.587, 0.114]))
