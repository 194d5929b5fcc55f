"""The edges of a box in an image, cut where they pass the camera."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from avsec_gym.geometry import Floats, project

_STROKE = [0, 1, 2, 3, 0, 4, 5, 6, 7, 4, 5, 1, 2, 6, 7, 3]
"""All twelve edges in one stroke, by the corners of `box_corners`."""
_NEAR = 0.3
"""Metres before the camera behind which nothing is drawn."""


def edges_in_image(corners: Floats, projection: Floats) -> Iterator[Floats]:
    """Both ends of each edge that lies before the camera, or as much of it as does.

    Args:
        corners: The box's corners in the camera frame, in the order of `box_corners`, shape (8, 3).
        projection: Camera frame to pixels, shape (3, 4).

    Returns:
        Pixels, shape (2, 2): the nearer end first.
    """
    for start, end in pairwise(corners[_STROKE]):
        low, high = sorted((start, end), key=lambda corner: float(corner[2]))
        if high[2] < _NEAR:
            continue
        if low[2] < _NEAR:
            low = low + (high - low) * (_NEAR - low[2]) / (high[2] - low[2])
        pixels, _ = project(projection, np.stack([low, high]))
        yield pixels
