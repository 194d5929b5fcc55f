"""Non-maximum suppression of boxes that stand on the ground, by their overlap seen from above."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from avsec_gym.box_overlap import overlap_area
from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel


def rotated_nms(rectangles: ArrayLike, scores: ArrayLike, threshold: float) -> NDArray[np.int64]:
    """Greedy: the best rectangle stays, whatever overlaps it too much goes, and so on.

    Args:
        rectangles: The rectangles, shape (N, 5), as `avsec_gym.box_overlap` takes them.
        scores: The scores, shape (N,); where two are equal, the first of the rows is the better.
        threshold: A rectangle goes whose intersection over union with a better one that stays
            is above this.

    Returns:
        Rows that stay, best score first.

    Example:
        >>> rotated_nms([[0, 0, 4, 2, 0], [0.5, 0, 4, 2, 0], [9, 0, 4, 2, 0]], [0.5, 0.9, 0.7], 0.6)
        array([1, 2])
    """
    rows = np.ascontiguousarray(rectangles, np.float64).reshape(-1, 5)
    order = np.argsort(-np.asarray(scores, np.float64), kind="stable")
    return order[_stays(rows[order], threshold)]


@kernel(nogil=True)
def _stays(rectangles: Floats, threshold: float) -> NDArray[np.bool_]:
    """Of rectangles in order of their scores, a mask of those that stay."""
    stays = np.ones(len(rectangles), np.bool_)
    areas = rectangles[:, 2] * rectangles[:, 3]
    # Invariant: of the rectangles before i, those that still stay are the survivors.
    for i in range(len(rectangles)):
        if not stays[i]:
            continue
        for j in range(i + 1, len(rectangles)):
            if stays[j]:
                common = overlap_area(rectangles[i], rectangles[j])
                stays[j] = common <= threshold * (areas[i] + areas[j] - common)
    return stays
