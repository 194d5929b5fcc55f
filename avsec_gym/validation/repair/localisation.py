"""Where in an attacked camera's image the damage is (thesis, section 6.2: future work).

Disparities show that something is wrong: where light hides the scene, a matcher finds nothing.
But it copes with light that only brightens, so that the damage is wider than its holes.  What
shows all of it is the image itself beside the image that the trusted sensors predict: their depth
gives the place of each pixel in a trusted camera's image.
"""

from __future__ import annotations

from collections.abc import Iterable

import cv2
import numpy as np
from numpy.typing import NDArray

from avsec_gym.frame import Image, SensorFrame
from avsec_gym.sensor_system import Sensor
from avsec_gym.validation.evidence.brightness import differing_pixels, equally_exposed
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.evidence.reprojection import Mask
from avsec_gym.validation.repair.large_parts import large_parts
from avsec_gym.validation.repair.trusted_view import TrustedView, trusted_view

_COARSE = 4
"""Pixels to a side of the blocks that vote together."""
_NEIGHBOURHOOD = 1.5
"""Standard deviation of a vote's reach, blocks."""
_SMALLEST = 0.003
"""Share of the image; smaller patches and holes are ignored."""


def damaged_pixels(
    frame: SensorFrame, camera: int, trusted: Iterable[Sensor], depth: PairDepth | None = None
) -> Mask:
    """The part of an attacked camera's image that contradicts the trusted sensors.

    Args:
        frame: The tampered frame.
        camera: The attacked camera.
        trusted: Sensors that are not: a camera, and a second one or the LiDAR.
        depth: How the disparities of two trusted cameras are found.

    Returns:
        Shape (H, W).

    Raises:
        ConfigurationError: See `trusted_view`.
        DataError: The frame lacks a sensor, or its file is broken.
    """
    return contradicting_pixels(frame.image(camera), trusted_view(frame, camera, trusted, depth))


def contradicting_pixels(image: Image, view: TrustedView) -> Mask:
    """See `damaged_pixels`, with the view at hand.

    Each pixel that is believed votes: whether it differs from the trusted image, see
    `differing_pixels`.  Votes are averaged over a neighbourhood, the majority decides, and small
    patches and holes are ignored.
    """
    expected = equally_exposed(view.image, image, view.believed)
    brighter, darker, judged = differing_pixels(image, expected, view.believed)
    votes = np.where(brighter | darker, np.float32(1), np.float32(-1))
    votes[~judged] = 0.0
    return _without_specks(_majority(votes))


def _majority(votes: NDArray[np.float32]) -> Mask:
    height, width = votes.shape
    size = max(1, width // _COARSE), max(1, height // _COARSE)
    coarse = cv2.resize(votes, size, interpolation=cv2.INTER_AREA)
    smooth = cv2.GaussianBlur(coarse, (0, 0), _NEIGHBOURHOOD)
    return np.asarray(cv2.resize(smooth, (width, height), interpolation=cv2.INTER_LINEAR) > 0)


def _without_specks(mask: Mask) -> Mask:
    least = _SMALLEST * mask.size
    patches = large_parts(mask, least)
    return ~large_parts(~patches, least)
