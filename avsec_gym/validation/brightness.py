"""What two cameras see of one surface is as bright in both images; light into one of them is not.

A matcher compares edges rather than grey levels, so that it copes with cameras that are exposed
otherwise; it also copes with most of a facula, and where it does, disparities agree.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from avsec_gym.frame import Image
from avsec_gym.kitti.map_files import Disparity
from avsec_gym.validation.reprojection import Mask

MIN_LIGHT = 25
"""Grey levels by which a pixel differs from what it should be: a tenth of the range."""
FEWEST = 100
"""Pixels to be compared; to know fewer is as bad as if all of them were inconsistent."""
_SHIFT = 2
"""Pixels by which a depth may paint an image too far left or right."""
_DARKEST = 8
"""Grey levels; darker pixels tell nothing of how two cameras are exposed."""
_WHITE = 250
_EXPOSURES, _EXPOSURE_BINS = 0.7, 141
"""Two cameras' exposures differ by less than a factor of two; counted by the percent."""


def brightness_inconsistency(image: Image, other: Image, disparity: Disparity) -> float:
    """The share of matched pixels that are not as bright in both images of a pair.

    Args:
        image: Of the reference camera, shape (H, W, 3).
        other: Of the camera to its right, the same shape.
        disparity: In the view of the reference, pixels, NaN where unknown, shape (H, W).

    Returns:
        From 0 to 1; 1 with fewer than `FEWEST` pixels.
    """
    if is_grey(other):
        # Which colour the light has, only one of them can tell.
        image = _without_colours(image)
    height, width = disparity.shape
    column = np.arange(width, dtype=np.float32) - disparity
    known = column >= 0
    column = np.where(known, column, np.float32(0))
    row = np.repeat(np.arange(height, dtype=np.float32)[:, None], width, axis=1)
    painted = cv2.remap(other, column, row, cv2.INTER_LINEAR)
    # What is not known is no surrounding to compare with.
    expected = equally_exposed(np.where(known[..., None], painted, image), image, known)
    differs, judged = differing_pixels(image, expected, known)
    count = int(judged.sum())
    return int(differs.sum()) / count if count >= FEWEST else 1.0


def differing_pixels(image: Image, expected: Image, known: Mask) -> tuple[Mask, Mask]:
    """Where an image's brightness is other than it should be, and where that can be told.

    A pixel differs if it lies outside of what the expected image has within two pixels, by
    `MIN_LIGHT` and in some colour.  White where the scene is almost white tells nothing.

    Args:
        image: As it came, shape (H, W, 3).
        expected: As it should be, equally exposed.
        known: Where that is known, shape (H, W).

    Returns:
        Two masks; the first within the second.
    """
    around = np.ones((3, 2 * _SHIFT + 1), np.uint8)
    brighter = cv2.subtract(image, cv2.dilate(expected, around))
    darker = cv2.subtract(cv2.erode(expected, around), image)
    differs = cv2.max(brighter, darker).max(axis=2) > MIN_LIGHT
    blind = (image.min(axis=2) >= _WHITE) & (expected.min(axis=2) >= 255 - MIN_LIGHT)
    judged = known & ~blind
    return differs & judged, judged


def equally_exposed(expected: Image, image: Image, known: Mask) -> Image:
    """What a camera should see as it would have exposed it, without colours if it is grey.

    One factor for each colour, that which the most pixels agree on: light spreads the others,
    so that it may cover more than half of the image.

    Args:
        expected: From other cameras, shape (H, W, 3).
        image: That the camera took.
        known: Where something is expected, shape (H, W).
    """
    if is_grey(image):
        expected = _without_colours(expected)
    telling = known & (expected.min(axis=2) >= _DARKEST) & (image.max(axis=2) < _WHITE)
    ratios = np.log(np.maximum(image[telling], 1) / expected[telling].astype(np.float32))
    factors = np.exp([_most_common(ratios[:, colour]) for colour in range(3)], dtype=np.float32)
    return np.rint(np.minimum(expected * factors, 255.0)).astype(np.uint8)


def is_grey(image: Image) -> bool:
    """Whether all pixels have the same red, green and blue."""
    return bool((image[..., :1] == image).all())


def _without_colours(image: Image) -> Image:
    return np.repeat(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)[..., None], 3, axis=2)


def _most_common(ratios: NDArray[np.float32]) -> float:
    counts, edges = np.histogram(ratios, _EXPOSURE_BINS, (-_EXPOSURES, _EXPOSURES))
    if not counts.any():
        return 0.0
    best = int(np.convolve(counts, np.ones(5), "same").argmax())
    return float(0.5 * (edges[best] + edges[best + 1]))
