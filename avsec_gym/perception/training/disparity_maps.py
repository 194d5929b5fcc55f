"""Disparity maps for training: seen from the other camera, and reduced without blurred edges."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avsec_gym.perception.training.sample import Map

_SAME_SURFACE = 1.0
"""Pixels; neighbours that differ more are taken for two surfaces."""


def seen_from_right(left: Map) -> Map:
    """The right camera's disparity map, as far as the left camera sees its pixels.

    Args:
        left: The disparities of the left image, shape (H, W), pixels, 0 where unknown.

    Returns:
        Of the right image, the same shape; 0 where nothing that the left camera sees falls.
    """
    height, width = left.shape
    row, column = np.nonzero(left > 0)
    disparity = left[row, column]
    place = column - disparity
    right = np.zeros(height * width, np.float32)
    # Far ones first, so that what is nearer overwrites them.
    order = np.argsort(disparity, kind="stable")
    # A surface that looks wider from the right would have gaps if each pixel hit only one.
    targets = np.stack([np.floor(place[order]), np.ceil(place[order])], axis=1).astype(np.int64)
    inside = (targets >= 0) & (targets < width)
    flat = row[order, None] * width + targets
    right[flat[inside]] = np.repeat(disparity[order], 2)[inside.ravel()]
    return right.reshape(height, width)


def reduced_disparity(disparity: Map, height: int, width: int) -> Map:
    """A map for the image resized to another size, in that image's pixels.

    A pixel of the result gets the value at its centre: between four pixels of one surface
    bilinear, at an edge that of the nearest pixel (never a mixture of two surfaces), and where
    that is unknown, as in a sparse map, the largest of the four.

    Args:
        disparity: The disparities, shape (H, W), 0 where unknown.
        height: The height of the result.
        width: The width of the result.
    """
    if disparity.shape == (height, width):
        return disparity
    scale = width / disparity.shape[1]
    (above, below, down), (before, after, along) = (
        _neighbours(new, old) for new, old in zip((height, width), disparity.shape, strict=True)
    )
    corners = np.stack([disparity[np.ix_(v, u)] for v in (above, below) for u in (before, after)])
    down, along = down[:, None], along[None, :]
    weights = np.stack(
        [(1 - down) * (1 - along), (1 - down) * along, down * (1 - along), down * along]
    )
    smooth = (corners * weights).sum(axis=0)
    nearest = np.take_along_axis(corners, weights.argmax(axis=0)[None], axis=0)[0]
    largest = corners.max(axis=0)
    one_surface = (corners.min(axis=0) > 0) & (largest - corners.min(axis=0) < _SAME_SURFACE)
    value = np.where(one_surface, smooth, np.where(nearest > 0, nearest, largest))
    return np.asarray(value * scale, np.float32)


def _neighbours(new: int, old: int) -> tuple[NDArray[np.intp], NDArray[np.intp], Map]:
    """Pixels before and after each new pixel's centre, and how far it is between them."""
    centre = np.clip((np.arange(new) + 0.5) * old / new - 0.5, 0, old - 1)
    before = np.floor(centre).astype(np.intp)
    return before, np.minimum(before + 1, old - 1), (centre - before).astype(np.float32)
