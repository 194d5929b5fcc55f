"""What agents may see of images: numbers, a small image, or both."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avsec_gym.frame import Image

FEATURES, IMAGES, BOTH = "features", "images", "both"
"""Names of what an agent sees; `BOTH` is a dictionary of the first two."""
THUMBNAILS = "thumbnails"
"""Name of a pair of small images, with its calibration."""
FRAME = "frame"
"""Name of what a driver sees beside features: the frame that the car's sensors deliver."""
THUMBNAIL = (48, 160)
"""Height and width of a small image, pixels: few enough for the networks of stable-baselines3's
`CnnPolicy` to have less than five million weights."""


def thumbnail(image: Image) -> NDArray[np.uint8]:
    """An image made small, each pixel the mean of those that it stands for, shape (48, 160, 3).

    Args:
        image: Shape (H, W, 3).
    """
    return resized(image, THUMBNAIL)


def resized(image: Image, size: tuple[int, int]) -> NDArray[np.uint8]:
    """A copy of an image in another size, each pixel the mean of those that it stands for.

    Args:
        image: Shape (H, W, 3).
        size: Height and width, pixels.

    Returns:
        Shape (height, width, 3).
    """
    import cv2

    if image.shape[:2] == size:
        return np.array(image, np.uint8)
    return np.array(cv2.resize(image, size[::-1], interpolation=cv2.INTER_AREA), np.uint8)
