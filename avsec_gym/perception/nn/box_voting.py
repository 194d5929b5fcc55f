"""Box voting: what stays after the suppression becomes the mean of all that meant the same.

Neighbours err in different directions, and the one with the best score is not the best placed
(Gidaris and Komodakis, ICCV 2015, in 2D).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avsec_gym.box_overlap import ground_rectangles, rectangle_iou
from avsec_gym.geometry import Floats, wrap_angle


def voted_boxes(
    location: Floats,
    dimensions: Floats,
    rotation_y: Floats,
    scores: Floats,
    kept: NDArray[np.int64],
    *,
    overlap: float,
    turn: float,
) -> tuple[Floats, Floats, Floats]:
    """Means of the candidates that vote for each box, weighted by score.

    Args:
        location: Bottom centres of N candidates of one class, shape (N, 3).
        dimensions: Height, width, length, shape (N, 3).
        rotation_y: The headings, shape (N,).
        scores: Positive, shape (N,).
        kept: Rows of the M boxes to be voted for; each of them votes for itself.
        overlap: Candidates vote that overlap the box by more (intersection over union from above).
        turn: The largest angle between it and them, radians, whichever way they point: which way
            the box points is voted on, too.

    Returns:
        Location (M, 3), dimensions (M, 3) and rotation_y (M,).
    """
    rectangles = ground_rectangles(location, dimensions, rotation_y)
    turned = wrap_angle(rotation_y[None] - rotation_y[kept, None])
    reversed_ = np.abs(turned) > np.pi / 2
    turned = np.where(reversed_, wrap_angle(turned + np.pi), turned)
    votes = (rectangle_iou(rectangles[kept], rectangles) > overlap) & (np.abs(turned) < turn)
    votes[np.arange(len(kept)), kept] = True
    weights = votes * scores
    weights /= weights.sum(axis=1, keepdims=True)
    other_way = (weights * reversed_).sum(axis=1) > 0.5
    yaw = rotation_y[kept] + (weights * turned).sum(axis=1) + np.pi * other_way
    return weights @ location, weights @ dimensions, wrap_angle(yaw)
