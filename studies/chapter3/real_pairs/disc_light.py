"""How much brighter a disc is in one image than the other camera of a pair would have it.

The mean over a disc is what remains of a faint light when the noise of single pixels is averaged
out.  Clean pairs have discs, too, that differ: surfaces that shine into one camera, a matcher's
errors.  No threshold on that mean separates a light that is no brighter than the brightest clean
disc of its size from a clean pair: that is where physics ends it, for whoever compares two images
this way.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from avsec_gym.attacks.facula import EDGE
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.map_files import Disparity
from avsec_gym.validation.evidence.brightness import compared_images
from avsec_gym.validation.evidence.reprojection import Mask
from studies.chapter3.real_pairs.image_pairs import LEFT, RIGHT

MEAN_OF_PEAK = (1.0 - EDGE) / 2.0
"""What the mean of a Gaussian facula over its disc is of its peak: 43 %."""
_WHITE = 250
_KNOWN = 0.5
"""Share of a disc whose expected brightness is known, at least."""
_SHRUNK = 8
"""Discs of twice this radius, pixels, are looked for in images of half the size, and so on: what is
averaged over hundreds of pixels needs no single ones."""

Residual = NDArray[np.float32]
"""Differences of pixels, grey levels, shape (H, W)."""


@dataclass(frozen=True, eq=False)
class PairDifference:
    """What one image has more than the other camera expects.

    Args:
        residual: Mean of the three colours, grey levels, 0 where it is not known, shape (H, W).
        known: Where it is known: matched, and white in neither image.
    """

    residual: Residual
    known: Mask

    @property
    def pixel_noise(self) -> float:
        """Standard deviation of single pixels, grey levels: 1.48 times the median deviation."""
        found = self.residual[self.known]
        return float(1.4826 * np.median(np.abs(found - np.median(found)))) if found.size else 0.0


def pair_difference(frame: SensorFrame, disparity: Disparity) -> PairDifference:
    """Compare the images of a pair, equally exposed.

    Args:
        frame: A frame with the images `LEFT` and `RIGHT`.
        disparity: The disparity of the left image, pixels, NaN where unknown, shape (H, W).
    """
    image, expected, known = compared_images(frame.image(LEFT), frame.image(RIGHT), disparity)
    known = known & (image.max(axis=2) < _WHITE) & (expected.least.max(axis=2) < _WHITE)
    residual = (image.astype(np.float32) - expected.least).mean(axis=2)
    return PairDifference(np.where(known, residual, np.float32(0)), known)


def brightest_disc(difference: PairDifference, radius: float) -> float:
    """The largest mean difference, brighter or darker, over a disc of this radius.

    Args:
        difference: The difference of a pair.
        radius: Radius of the disc, pixels.

    Returns:
        Grey levels; 0 where no disc is known in half of its pixels.
    """
    values, weights = difference.residual, difference.known.astype(np.float32)
    while radius >= 2 * _SHRUNK:
        size = max(values.shape[1] // 2, 1), max(values.shape[0] // 2, 1)
        values, weights = (
            np.asarray(cv2.resize(part, size, interpolation=cv2.INTER_AREA), np.float32)
            for part in (values, weights)
        )
        radius /= 2
    reach = int(radius)
    rows, columns = np.ogrid[-reach : reach + 1, -reach : reach + 1]
    disc = (rows**2 + columns**2 <= radius**2).astype(np.float32)
    total, count = (
        cv2.filter2D(part, cv2.CV_32F, disc, borderType=cv2.BORDER_CONSTANT)
        for part in (values, weights)
    )
    enough = count >= _KNOWN * disc.sum()
    return float(np.abs(total[enough] / count[enough]).max()) if enough.any() else 0.0
