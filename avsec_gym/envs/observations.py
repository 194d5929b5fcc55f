"""What agents may see of images: numbers, a small image, or both."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avsec_gym.frame import Image

FEATURES, IMAGES, BOTH = "features", "images", "both"
"""Names of what an agent sees; `BOTH` is a dictionary of the first two."""
THUMBNAIL = (48, 160)
"""Height and width of a small image, pixels: few enough for the networks of stable-baselines3's
`CnnPolicy` to have less than five million weights."""


def thumbnail(image: Image) -> NDArray[np.uint8]:
    """An image made small, each pixel the mean of those that it stands for, shape (48, 160, 3).

    Args:
        image: Shape (H, W, 3).
    """
    import cv2

    small = cv2.resize(image, THUMBNAIL[::-1], interpolation=cv2.INTER_AREA)
    return np.array(small, np.uint8)
