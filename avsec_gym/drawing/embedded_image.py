"""An image inside a page."""

from __future__ import annotations

import base64

import cv2
import numpy as np
from numpy.typing import NDArray

_QUALITY = 80
"""Quality of WebP."""


def embedded(image: NDArray[np.uint8]) -> str:
    """A data URI.

    Args:
        image: Image in red, green and blue, shape (H, W, 3).
    """
    return embedded_file(webp(image))


def webp(image: NDArray[np.uint8]) -> bytes:
    """A WebP file.

    Args:
        image: Image in red, green and blue, shape (H, W, 3).
    """
    bgr = cv2.cvtColor(image, cv2.COLOR_RGB2BGR)
    _, content = cv2.imencode(".webp", bgr, [cv2.IMWRITE_WEBP_QUALITY, _QUALITY])
    return content.tobytes()


def embedded_file(content: bytes) -> str:
    """A data URI.

    Args:
        content: A WebP file.
    """
    return "data:image/webp;base64," + base64.b64encode(content).decode()
