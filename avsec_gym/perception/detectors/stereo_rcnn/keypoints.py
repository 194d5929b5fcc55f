"""What both images show of the true cars, and keypoints and borders to and from the network's grid.

A car's *perspective keypoint* is the bottom corner that is seen between its left-most and
right-most ones; its *borders* are the first and last column where no nearer object hides it
(Li et al. 2019, section 3.2).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from avsec_gym.boxes import Boxes3D
from avsec_gym.geometry import Floats, wrap_angle
from avsec_gym.perception.detectors.stereo_rcnn.box_solver import CORNERS, Indices
from avsec_gym.perception.detectors.stereo_rcnn.stereo_camera import StereoCamera

OCCLUDERS = ("Car", "Van", "Truck", "Misc")
"""What can hide a car in the depth of each column."""

_MOST_TRUNCATED, _MOST_OCCLUDED = 0.98, 3
_SMALLEST_HEIGHT, _SMALLEST_VISIBLE = 10.0, 3.0
_BORDER_MARGIN, _CORNER_MARGIN = 5.0, 3.0
_NEAR = 0.1


@dataclass(frozen=True, eq=False)
class StereoTruth:
    """N cars as both images show them, in pixels.

    Args:
        left: Projected 3D boxes, clipped to the image, shape (N, 4): left, top, right, bottom.
        right: The same in the right image.
        keypoints: u of the four bottom corners (`CORNERS`) in the left image, NaN unless the
            corner is the keypoint, shape (N, 4).
        borders: First and last visible column, shape (N, 2).
        dimensions: Height, width, length, metres, shape (N, 3).
        alpha: Observation angle in the left camera's frame, shape (N,).
        classes: 1 for the first of the categories, and so on, shape (N,).
        location: Bottom centres in the left camera's frame, metres, shape (N, 3).
    """

    left: Floats
    right: Floats
    keypoints: Floats
    borders: Floats
    dimensions: Floats
    alpha: Floats
    classes: Indices
    location: Floats

    def __len__(self) -> int:
        return len(self.left)

    @property
    def union(self) -> Floats:
        """Boxes around both, shape (N, 4)."""
        least = np.minimum(self.left, self.right)[:, :2]
        return np.hstack([least, np.maximum(self.left, self.right)[:, 2:]])

    def resized(self, height: float, width: float) -> StereoTruth:
        """The keypoints in pixels of images that are so many times as high and as wide."""
        scale = np.array([width, height, width, height])
        return replace(
            self,
            left=(self.left + 0.5) * scale - 0.5,
            right=(self.right + 0.5) * scale - 0.5,
            keypoints=(self.keypoints + 0.5) * width - 0.5,
            borders=(self.borders + 0.5) * width - 0.5,
        )


def stereo_truth(
    boxes: Boxes3D, camera: StereoCamera, categories: Sequence[str] = ("Car",)
) -> StereoTruth:
    """The objects that can be learned: seen well enough in both images.

    Args:
        boxes: The labels of a frame.
        camera: The camera, with the size of the images that the boxes are wanted in.
        categories: What is detected.
    """
    # All that can hide something, in the frame of the left camera, and seen in both images.
    ahead = boxes.location[:, 2] + camera.offset[2] > _NEAR
    boxes = boxes[ahead & np.isin(boxes.category, [*OCCLUDERS, *categories])]
    location = boxes.location + camera.offset
    x, z = _corners(boxes, location)
    left, right = _views(boxes, location, x, z, camera)
    u = x / z * camera.focal_length[0] + camera.centre[0]
    depth = location[:, 2]
    # The columns of each view that no nearer object hides.
    borders, right_borders = (_visible(view, depth, camera.size[1]) for view in (left, right))
    classes = sum(
        (i * (boxes.category == name) for i, name in enumerate(categories, 1)),
        np.zeros(len(boxes), np.intp),
    )
    # Objects of the classes that are large enough and seen well enough.
    kept = (classes > 0) & (left[:, 3] - left[:, 1] > _SMALLEST_HEIGHT)
    for visible in (borders, right_borders):
        kept &= visible[:, 1] - visible[:, 0] > _SMALLEST_VISIBLE
    if boxes.truncation is not None:
        kept &= boxes.truncation < _MOST_TRUNCATED
    if boxes.occlusion is not None:
        kept &= boxes.occlusion < _MOST_OCCLUDED
    alpha = wrap_angle(boxes.rotation_y - np.arctan2(location[:, 0], depth))
    keypoints = _visible_keypoints(u, z, depth, borders)
    return StereoTruth(
        left[kept],
        right[kept],
        keypoints[kept],
        borders[kept],
        boxes.dimensions[kept],
        alpha[kept],
        classes[kept],
        location[kept],
    )


def decode_keypoints(cells: Indices, boxes: Floats, grid: int) -> tuple[Floats, Indices]:
    """Where the keypoint is and which corner it is.

    Args:
        cells: Best of the 4 x grid cells, shape (N,).
        boxes: The regions of interest in the left image, shape (N, 4).
        grid: Cells across a region.

    Returns:
        u, shape (N,), and corner, shape (N,).
    """
    return decode_borders(cells % grid, boxes, grid), cells // grid


def decode_borders(cells: Floats | Indices, boxes: Floats, grid: int) -> Floats:
    """Columns u of cells (N, ...) of regions (N, 4): the inverse of the targets' coding."""
    width = boxes[:, 2] - boxes[:, 0] + 1
    shape = (-1, *[1] * (cells.ndim - 1))
    return np.asarray(cells * (width / grid).reshape(shape) + boxes[:, 0].reshape(shape))


def checked_borders(borders: Floats, boxes: Floats, image_width: int) -> Floats:
    """Predicted borders (N, 2), or those that the boxes (N, 4) imply where these are far wider.

    Without depth, what reaches further down in the image is taken for nearer.
    """
    inferred = _visible(boxes, 1.0 / np.maximum(boxes[:, 3], 1.0), image_width)
    too_narrow = borders[:, 1] - borders[:, 0] < 0.5 * (inferred[:, 1] - inferred[:, 0])
    return np.where(too_narrow[:, None], inferred, borders)


def _corners(boxes: Boxes3D, location: Floats) -> tuple[Floats, Floats]:
    """X and z of the four bottom corners, each (N, 4)."""
    across, along = np.moveaxis(CORNERS * boxes.dimensions[:, None, 1:], 2, 0)
    theta = boxes.rotation_y[:, None] + np.pi / 2
    cos, sin = np.cos(theta), np.sin(theta)
    x = location[:, :1] + cos * across + sin * along
    z = location[:, 2:] - sin * across + cos * along
    # What is behind the camera lies far outside of the image on its own side.
    return x, np.maximum(z, _NEAR)


def _views(
    boxes: Boxes3D, location: Floats, x: Floats, z: Floats, camera: StereoCamera
) -> tuple[Floats, Floats]:
    (focal_u, focal_v), (centre_u, centre_v) = camera.focal_length, camera.centre
    height, width = camera.size
    bottom = location[:, 1, None] / z * focal_v + centre_v
    top = (location[:, 1] - boxes.dimensions[:, 0])[:, None] / z * focal_v + centre_v
    views = []
    for shift in (0.0, camera.baseline):
        u = (x - shift) / z * focal_u + centre_u
        edges = np.column_stack([u.min(axis=1), top.min(axis=1), u.max(axis=1), bottom.max(axis=1)])
        views.append(np.clip(edges, 0, [width - 1, height - 1, width - 1, height - 1]))
    return views[0], views[1]


def _visible(boxes: Floats, depth: Floats, image_width: int) -> Floats:
    """First and last column (N, 2) that no nearer box hides; none if both ends are hidden."""
    first = np.clip(boxes[:, 0].astype(int), 0, image_width - 1)
    last = np.clip(boxes[:, 2].astype(int), 0, image_width - 1)
    nearest = np.full(image_width, np.inf)
    for start, stop, z in zip(first, last, depth, strict=True):
        nearest[start : stop + 1] = np.minimum(nearest[start : stop + 1], z)
    visible = boxes[:, [0, 2]].copy()
    for i, (start, stop, z) in enumerate(zip(first, last, depth, strict=True)):
        free: NDArray[np.bool_] = nearest[start : stop + 1] >= z
        if free[-1] and not free[0]:
            visible[i, 0] = start + np.flatnonzero(~free)[-1]
        elif free[0] and not free[-1]:
            visible[i, 1] = start + np.flatnonzero(free)[-1]
        elif not free[0]:
            visible[i, 1] = visible[i, 0]
    return visible


def _visible_keypoints(u: Floats, z: Floats, depth: Floats, borders: Floats) -> Floats:
    """U where a corner is on the near side, inside the box and not hidden, else NaN."""
    inside = (u >= u.min(axis=1, keepdims=True) + _CORNER_MARGIN) & (
        u <= u.max(axis=1, keepdims=True) - _CORNER_MARGIN
    )
    seen = (u >= borders[:, :1] - _BORDER_MARGIN) & (u <= borders[:, 1:] + _BORDER_MARGIN)
    return np.where(inside & seen & (z <= depth[:, None]), u, np.nan)
