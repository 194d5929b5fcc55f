"""The connected parts of a mask that are large enough to count."""

from __future__ import annotations

import cv2
import numpy as np

from avsec_gym.validation.evidence.reprojection import Mask


def large_parts(mask: Mask, least: float) -> Mask:
    """A mask without its small parts.

    Args:
        mask: The mask, shape (H, W); neighbours also touch at corners.
        least: The fewest pixels of a part that is kept.
    """
    _, labels, numbers, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8))
    large = numbers[:, cv2.CC_STAT_AREA] >= least
    large[0] = False  # The background.
    return np.asarray(large[labels])
