"""What two cameras see of one surface is as bright in both images; light into one of them is not.

A matcher compares edges rather than grey levels, so that it copes with cameras that are exposed
otherwise; it also copes with most of a facula, and where it does, disparities agree.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from avsec_gym.frame import Image
from avsec_gym.kitti.map_files import Disparity
from avsec_gym.validation.evidence.reprojection import Mask

MIN_LIGHT = 25
"""Grey levels by which a pixel differs from what it should be: a tenth of the range."""
FEWEST = 100
"""Pixels to be compared; to know fewer is as bad as if all of them were inconsistent."""
_SHIFT = 2
"""Pixels by which a depth may paint an image too far left or right."""
_PATCH = 15
"""Pixels to a side of what lies around one."""
_DARKEST = 8
"""Grey levels; darker pixels hold no information on how two cameras are exposed."""
_WHITE = 250
_EXPOSURES, _EXPOSURE_BINS = 0.7, 281
"""Two cameras' exposures differ by less than a factor of two; searched by half a percent."""
_EXPOSED = 4.0
"""Grey levels; a pixel agrees with an exposure that puts it this near."""


class Brightness(NamedTuple):
    """Shares of matched pixels that are not as bright in both images of a pair, from 0 to 1."""

    brighter: float
    """The brighter pixels in the reference's image: light into the reference."""
    darker: float
    """The darker pixels in the reference's image: light into the other camera."""
    patches: float
    """Brighter, or darker, and so are most around them: light, not a matcher's errors."""


class Expected(NamedTuple):
    """What an image should be, pixel by pixel; each of shape (H, W, 3)."""

    least: Image
    most: Image
    """More than `least` where the other camera overflowed, so that the brightness is unknown."""


def brightness_inconsistency(image: Image, other: Image, disparity: Disparity) -> Brightness:
    """Which share of the matched pixels is not as bright in both images of a pair.

    Args:
        image: The image of the reference camera, shape (H, W, 3).
        other: The image of the camera to its right, the same shape.
        disparity: Disparity in the view of the reference, pixels, NaN where unknown, shape (H, W).

    Returns:
        All 1 with fewer than `FEWEST` pixels.
    """
    seen, expected, known = compared_images(image, other, disparity)
    brighter, darker, judged = differing_pixels(seen, expected, known)
    count = int(judged.sum())
    if count < FEWEST:
        return Brightness(1.0, 1.0, 1.0)
    most = sum(int((mask & _mostly(mask, judged)).sum()) for mask in (brighter, darker))
    return Brightness(int(brighter.sum()) / count, int(darker.sum()) / count, most / count)


def compared_images(
    image: Image, other: Image, disparity: Disparity
) -> tuple[Image, Expected, Mask]:
    """The reference's image, and what it should be by the other camera of a pair.

    Args:
        image: The image of the reference camera, as of `brightness_inconsistency`.
        other: The image of the camera to its right, as of `brightness_inconsistency`.
        disparity: The disparity in the view of the reference, as of `brightness_inconsistency`.

    Returns:
        The image, without colours where the other camera sees none; what it should be, equally
        exposed; and where that is known, shape (H, W).
    """
    if is_grey(other):
        # Only one of the cameras sees the colour of the light.
        image = without_colours(image)
    height, width = disparity.shape
    column = np.arange(width, dtype=np.float32) - disparity
    known = column >= 0
    column = np.where(known, column, np.float32(0))
    row = np.repeat(np.arange(height, dtype=np.float32)[:, None], width, axis=1)
    painted: Any = cv2.remap(other, column, row, cv2.INTER_LINEAR)
    # What is not known is no surrounding to compare with.
    painted = cv2.copyTo(painted, _flags(known), image.copy())
    return image, equally_exposed(painted, image, known), known


def differing_pixels(image: Image, expected: Expected, known: Mask) -> tuple[Mask, Mask, Mask]:
    """Where an image is brighter or darker than it should be, and where that is known.

    A pixel differs if it lies outside of what the expected image has within two columns and
    one row, by `MIN_LIGHT` and in some colour.  White where the scene may be white is no evidence.

    Args:
        image: The image as it came, shape (H, W, 3).
        expected: The image as it should be, equally exposed.
        known: The pixels where that is known, shape (H, W).

    Returns:
        Three masks: brighter and darker, which are within the third.
    """
    around = np.ones((3, 2 * _SHIFT + 1), np.uint8)
    above: Any = cv2.subtract(image, cv2.dilate(expected.most, around))
    below: Any = cv2.subtract(cv2.erode(expected.least, around), image)
    blind = (_least(image) >= _WHITE) & (_least(expected.most) >= 255 - MIN_LIGHT)
    judged = known & ~blind
    brighter, darker = (judged & (_most(excess) > MIN_LIGHT) for excess in (above, below))
    return brighter, darker & ~brighter, judged


def equally_exposed(expected: Image, image: Image, known: Mask) -> Expected:
    """What a camera should see as it would have exposed it, without colours if it is grey.

    One factor for each colour, that which the most pixels agree on: light spreads the others,
    so that it may cover more than half of the image.

    Args:
        expected: The image that other cameras give, shape (H, W, 3).
        image: The image that the camera took.
        known: The pixels where something is expected, shape (H, W).
    """
    if is_grey(image):
        expected = without_colours(expected)
    telling = _flags(
        known
        & (_least(expected) >= _DARKEST)
        & (_most(expected) < _WHITE)
        & (_most(image) < _WHITE)
    )
    factors = np.exp([_exposure(expected, image, colour, telling) for colour in range(3)])
    levels = np.arange(256, dtype=np.float32)[:, None] * factors.astype(np.float32)
    least = np.rint(np.minimum(levels, 255.0)).astype(np.uint8)
    most = least.copy()
    most[_WHITE:] = 255
    return Expected(*(np.asarray(cv2.LUT(expected, to[None]), np.uint8) for to in (least, most)))


def without_colours(image: Image) -> Image:
    """The image that a grey camera sees, which all colours reach alike, shape (H, W, 3)."""
    grey = cv2.transform(image, np.full((1, 3), 1 / 3, np.float32))
    return np.repeat(grey[..., None] if grey.ndim == 2 else grey, 3, axis=2)


def is_grey(image: Image) -> bool:
    """Whether all pixels have the same red, green and blue."""
    # A few pixels decide for most images.
    return all(bool((some[..., :1] == some).all()) for some in (image[::16, ::16], image))


def _mostly(pixels: Mask, judged: Mask) -> Mask:
    """Where more than half of the judged pixels around are some of these."""
    around = (_PATCH, _PATCH)
    share, of = (
        cv2.blur(np.asarray(mask, np.float32), around, borderType=cv2.BORDER_CONSTANT)
        for mask in (pixels, judged)
    )
    return np.asarray(share > 0.5 * of)


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
    """The logarithm of the factor that the most pixels agree on; 0 without such pixels."""
    # How many pixels have which two levels: all that counts of a million pixels, without a loop.
    levels = cv2.calcHist(
        [expected, image], [colour, 3 + colour], telling, [256, 256], [0, 256, 0, 256]
    ).ravel()
    if not levels.any():
        return 0.0
    begin, end = (np.bincount(limits.ravel(), levels, _EXPOSURE_BINS + 1) for limits in _AGREEING)
    agreeing = np.cumsum(begin - end)[:_EXPOSURE_BINS]
    # Of the first plateau the middle.
    best = np.flatnonzero(agreeing >= agreeing.max() - 0.5)
    length = int(np.argmin(np.r_[np.diff(best) == 1, False])) + 1
    return float(_FACTORS[best[:length]].mean())


def _agreeing() -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Of each expected and each seen level the first factor that fits, and the first that no more.

    Shapes (256, 256), numbers of `_FACTORS`.
    """
    level = np.arange(256, dtype=np.float64)
    seen, expected = level[None], np.maximum(level, 1)[:, None]
    least, most = ((seen + side * _EXPOSED) / expected for side in (-1, 1))
    with np.errstate(divide="ignore", invalid="ignore"):
        begin = np.searchsorted(_FACTORS, np.log(np.maximum(least, 1e-9)), side="left")
        end = np.searchsorted(_FACTORS, np.log(most), side="right")
    return begin, end


_FACTORS = np.linspace(-_EXPOSURES, _EXPOSURES, _EXPOSURE_BINS)
_AGREEING = _agreeing()
