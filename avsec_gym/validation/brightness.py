"""What two cameras see of one surface is as bright in both images; light into one of them is not.

A matcher compares edges rather than grey levels, so that it copes with cameras that are exposed
otherwise; it also copes with most of a facula, and where it does, disparities agree.
"""

from __future__ import annotations

from typing import Any

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
    painted: Any = cv2.remap(other, column, row, cv2.INTER_LINEAR)
    # What is not known is no surrounding to compare with.
    painted = cv2.copyTo(painted, _flags(known), image.copy())
    expected = equally_exposed(painted, image, known)
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
    brighter: Any = cv2.subtract(image, cv2.dilate(expected, around))
    darker: Any = cv2.subtract(cv2.erode(expected, around), image)
    differs = np.maximum(_most(brighter), _most(darker)) > MIN_LIGHT
    blind = (_least(image) >= _WHITE) & (_least(expected) >= 255 - MIN_LIGHT)
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
    telling = _flags(known & (_least(expected) >= _DARKEST) & (_most(image) < _WHITE))
    factors = np.exp([_exposure(expected, image, colour, telling) for colour in range(3)])
    levels = np.arange(256, dtype=np.float32)[:, None] * factors.astype(np.float32)
    table = np.rint(np.minimum(levels, 255.0)).astype(np.uint8)
    return np.asarray(cv2.LUT(expected, table[None]), np.uint8)


def is_grey(image: Image) -> bool:
    """Whether all pixels have the same red, green and blue."""
    return bool((image[..., :1] == image).all())


def _without_colours(image: Image) -> Image:
    return np.repeat(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)[..., None], 3, axis=2)


def _least(image: Image) -> NDArray[np.uint8]:
    """Of a pixel's three colours."""
    red, green, blue = cv2.split(image)
    return np.asarray(cv2.min(cv2.min(red, green), blue), np.uint8)


def _most(image: Image) -> NDArray[np.uint8]:
    red, green, blue = cv2.split(image)
    return np.asarray(cv2.max(cv2.max(red, green), blue), np.uint8)


def _flags(mask: Mask) -> NDArray[np.uint8]:
    """As OpenCV takes it."""
    return mask.view(np.uint8)


def _exposure(expected: Image, image: Image, colour: int, telling: NDArray[np.uint8]) -> float:
    """The logarithm of the factor that the most pixels agree on; 0 where none tells."""
    # How many pixels have which two levels: all that counts of a million pixels, without a loop.
    levels = cv2.calcHist(
        [expected, image], [colour, 3 + colour], telling, [256, 256], [0, 256, 0, 256]
    )
    counts = np.bincount(_RATIO_BINS.ravel(), levels.ravel(), _EXPOSURE_BINS + 1)[:_EXPOSURE_BINS]
    if not counts.any():
        return 0.0
    best = int(np.convolve(counts, np.ones(5), "same").argmax())
    return float(0.5 * (_EDGES[best] + _EDGES[best + 1]))


def _ratio_bins() -> NDArray[np.intp]:
    """Of each expected and each seen level that bin which their ratio is in, shape (256, 256)."""
    level = np.maximum(np.arange(256, dtype=np.float64), 1)
    found = np.searchsorted(_EDGES, np.log(level / level[:, None]), side="right") - 1
    # Factors of more than two, either way, are no exposure.
    found[(found < 0) | (found >= _EXPOSURE_BINS)] = _EXPOSURE_BINS
    return found


_EDGES = np.linspace(-_EXPOSURES, _EXPOSURES, _EXPOSURE_BINS + 1)
_RATIO_BINS = _ratio_bins()
