"""Where in an attacked camera's image the damage is (thesis, section 6.2: future work).

Disparities say that something is wrong: where light hides the scene, a matcher finds nothing.
But it copes with light that only brightens, so that the damage is wider than its holes.  What
shows all of it is the image itself beside what the trusted sensors say it should be: their depth
tells where each pixel is in a trusted camera's image.
"""

from __future__ import annotations

from collections.abc import Iterable

import cv2
import numpy as np
from numpy.typing import NDArray

from avsec_gym.frame import Image, SensorFrame
from avsec_gym.sensor_system import Sensor
from avsec_gym.validation.large_parts import large_parts
from avsec_gym.validation.pair_depth import PairDepth
from avsec_gym.validation.reprojection import Mask
from avsec_gym.validation.trusted_view import TrustedView, is_grey, trusted_view

MIN_LIGHT = 25
"""Grey levels by which a damaged pixel differs from what it should be: a tenth of the range."""
_SHIFT = 2
"""Pixels by which a trusted depth may paint its image too far left or right."""
_DARKEST = 8
"""Grey levels; darker pixels tell nothing of how two cameras are exposed."""
_WHITE = 250
_EXPOSURES, _EXPOSURE_BINS = 0.7, 141
"""Two cameras' exposures differ by less than a factor of two; counted by the percent."""
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
        frame: The moment, tampered with.
        camera: The attacked one.
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

    Each pixel that is believed votes: whether its brightness lies outside of what the trusted
    image has within two pixels, by `MIN_LIGHT` and in some colour.  White where the scene is almost
    white tells nothing, and has no vote.  Votes are averaged over a neighbourhood, the majority
    decides, and small patches and holes are ignored.
    """
    expected = equally_exposed(view, image)
    around = np.ones((3, 2 * _SHIFT + 1), np.uint8)
    brightest = cv2.dilate(expected, around).astype(np.int16)
    darkest = cv2.erode(expected, around).astype(np.int16)
    difference = np.maximum(image - brightest, darkest - image).max(axis=2)
    votes = np.where(difference > MIN_LIGHT, np.float32(1), np.float32(-1))
    blind = (image.min(axis=2) >= _WHITE) & (expected.min(axis=2) >= 255 - MIN_LIGHT)
    votes[blind | ~view.believed] = 0.0
    return _without_specks(_majority(votes))


def equally_exposed(view: TrustedView, image: Image) -> Image:
    """The view's image as this camera would have exposed it, without colours if it is grey.

    One factor for each colour, that which the most pixels agree on: light spreads the others,
    so that it may cover more than half of the image.

    Args:
        view: Of the camera.
        image: That it took.
    """
    expected = view.image
    if is_grey(image):
        expected = np.repeat(cv2.cvtColor(expected, cv2.COLOR_RGB2GRAY)[..., None], 3, axis=2)
    telling = view.believed & (expected.min(axis=2) >= _DARKEST) & (image.max(axis=2) < _WHITE)
    ratios = np.log(np.maximum(image[telling], 1) / expected[telling].astype(np.float32))
    factors = np.exp([_most_common(ratios[:, colour]) for colour in range(3)], dtype=np.float32)
    return np.rint(np.minimum(expected * factors, 255.0)).astype(np.uint8)


def _most_common(ratios: NDArray[np.float32]) -> float:
    counts, edges = np.histogram(ratios, _EXPOSURE_BINS, (-_EXPOSURES, _EXPOSURES))
    if not counts.any():
        return 0.0
    best = int(np.convolve(counts, np.ones(5), "same").argmax())
    return float(0.5 * (edges[best] + edges[best + 1]))


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
