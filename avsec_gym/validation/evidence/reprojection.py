"""Depth and images carried from one camera of a rig to another."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from avsec_gym.frame import Calibration, Image
from avsec_gym.geometry import Floats

Depth = NDArray[np.float32]
"""Shape (H, W), metres along the camera's axis; NaN where unknown."""
Mask = NDArray[np.bool_]
"""Shape (H, W)."""

_SAME_SURFACE = 1.05
"""How much farther away than the nearest thing in its pixel a place still is part of it."""


def carried_depth(depth: Depth, calibration: Calibration, source: int, target: int) -> Depth:
    """What a camera sees of the surfaces whose depths are known in another camera's view.

    Each pixel is carried on its own to the pixels around where it falls; the nearest wins.

    Args:
        depth: The depths in the view of the source.
        calibration: The calibration of the rig.
        source: The camera that the depths are known in.
        target: The camera that looks.
    """
    rows, columns = np.nonzero(np.isfinite(depth))
    places = back_projected(depth, calibration, source)[rows, columns]
    u, v, ahead = _projected(places, calibration, target)
    result = np.full(depth.shape, np.inf, np.float32)
    # Both neighbours in the row, so that surfaces that come nearer leave no cracks.
    for column in (np.floor(u), np.ceil(u)):
        _keep_nearest(result, column, np.round(v), ahead)
    result[np.isinf(result)] = np.nan
    return result


def carried_image(
    image: Image, depth: Depth, calibration: Calibration, source: int, target: int
) -> tuple[Image, Mask]:
    """What a camera would see, painted with another camera's image.

    Args:
        image: The image of the source.
        depth: The depths in the view of the target.
        calibration: The calibration of the rig.
        source: The camera that took the image.
        target: The camera that looks.

    Returns:
        The image, and where it is to be believed: where the depth is known and the source sees the
        same surface, in its image and not hidden by a nearer one.
    """
    known = np.isfinite(depth)
    places = back_projected(np.where(known, depth, 1.0), calibration, target)
    u, v, ahead = _projected(places, calibration, source)
    painted = cv2.remap(
        image,
        u.astype(np.float32),
        v.astype(np.float32),
        cv2.INTER_LINEAR,
        None,
        cv2.BORDER_REPLICATE,
    )
    nearest = np.full(depth.shape, np.inf, np.float32)
    _keep_nearest(nearest, np.round(u[known]), np.round(v[known]), ahead[known])
    height, width = depth.shape
    inside = known & (u >= 0) & (u <= width - 1) & (v >= 0) & (v <= height - 1)
    pixel = np.round(v[inside]).astype(np.int64), np.round(u[inside]).astype(np.int64)
    believed = inside.copy()
    believed[inside] = ahead[inside] <= _SAME_SURFACE * nearest[pixel]
    return np.asarray(painted, np.uint8), believed


def back_projected(depth: Depth, calibration: Calibration, camera: int) -> Floats:
    """Places of a view's pixels in the rectified frame of camera 0, shape (H, W, 3), metres."""
    projection = calibration.projection(camera)
    height, width = depth.shape
    pixels = np.empty((height, width, 3))
    pixels[..., 0], pixels[..., 1] = np.arange(width), np.arange(height)[:, None]
    pixels[..., 2] = 1.0
    # P [x, y, z, 1] = depth [u, v, 1]; KITTI's last column has a third entry that is not 0.
    scaled = pixels * depth[..., None] - projection[:, 3]
    return np.asarray(scaled @ np.linalg.inv(projection[:, :3]).T)


def _projected(
    places: Floats, calibration: Calibration, camera: int
) -> tuple[Floats, Floats, Floats]:
    projection = calibration.projection(camera)
    homogeneous = places @ projection[:, :3].T + projection[:, 3]
    ahead = np.maximum(homogeneous[..., 2], 1e-3)
    return homogeneous[..., 0] / ahead, homogeneous[..., 1] / ahead, ahead


def _keep_nearest(nearest: Depth, column: Floats, row: Floats, ahead: Floats) -> None:
    height, width = nearest.shape
    inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
    pixel = row[inside].astype(np.int64), column[inside].astype(np.int64)
    np.minimum.at(nearest, pixel, ahead[inside].astype(np.float32))
