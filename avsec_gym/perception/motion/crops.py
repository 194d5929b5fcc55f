"""Crops of objects and of the same places in an earlier frame, as if nothing but we had moved.

Each pixel of a crop is taken to lie on the object's box, on the ground at its foot, or on a wall
behind it; so it has a place in space, which the earlier image shows somewhere.  The two crops of
an object that stands agree then, while one that moves has left its place.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import Image
from avsec_gym.geometry import Floats, box_corners, project

Crops = NDArray[np.uint8]
"""Shape (N, H, W, 3)."""

CONTEXT = 1.4
"""Sides of a crop as multiples of those of the object's 2D box."""

_NEAREST = 0.5
"""Metres: what is nearer has no place in the image."""
_SMALLEST = 4.0
"""Pixels: sides of the smallest object's 2D box."""
_MOST_SAMPLES = 6
"""The most samples in a crop's pixel, along each side."""


def object_regions(
    boxes: Boxes3D, projection: Floats, shape: tuple[int, int], context: float = CONTEXT
) -> Floats:
    """What of the image the crops show: the objects' 2D boxes with some context.

    Args:
        boxes: N objects; without 2D boxes, those around their 3D boxes.
        projection: P of the camera, shape (3, 4).
        shape: Height and width of the image.
        context: Sides as multiples of those of the 2D box.

    Returns:
        Left, top, right, bottom in pixels, shape (N, 4); they may reach beyond the image.
    """
    found = _around_boxes(boxes, projection) if boxes.box2d is None else boxes.box2d
    limit = np.array([shape[1] - 1.0, shape[0] - 1.0])
    low, high = np.clip(found[:, :2], 0, limit), np.clip(found[:, 2:], 0, limit)
    half = 0.5 * context * np.maximum(high - low, _SMALLEST)
    middle = 0.5 * (low + high)
    return np.concatenate([middle - half, middle + half], axis=1)


def current_crops(image: Image, regions: Floats, size: tuple[int, int]) -> Crops:
    """Regions of an image in one size; black beyond the image.

    Args:
        image: The image, shape (H, W, 3).
        regions: The regions of `object_regions`, shape (N, 4).
        size: Height and width of the crops.
    """
    return _crops(
        _sampled(image, _pixels(region, size, count), count)
        for region, count in zip(regions, _samples(regions, size), strict=True)
    ).reshape(-1, *size, 3)


def earlier_crops(
    image: Image,
    regions: Floats,
    size: tuple[int, int],
    boxes: Boxes3D,
    projection: Floats,
    motion: Floats,
    ways: Floats | None = None,
) -> Crops:
    """The places that the current crops show, in an earlier image.

    Args:
        image: The earlier one, shape (H, W, 3).
        regions: The regions of the current image, shape (N, 4).
        size: Height and width of the crops.
        boxes: The objects now.
        projection: P of the camera, shape (3, 4).
        motion: The motion of `ego_motion`: from the current to the earlier camera frame, shape (4,
            4).
        ways: The metres that each object is taken to have driven since, along its heading, shape
            (N,); none if None.
    """
    crops = []
    for index, count in enumerate(_samples(regions, size)):
        places, on_box = places_of(_pixels(regions[index], size, count), boxes, index, projection)
        if ways is not None:
            places = places - ways[index] * on_box[..., None] * heading(boxes, index)
        crops.append(_sampled(image, earlier_pixels(places, projection, motion), count))
    return _crops(crops).reshape(-1, *size, 3)


def heading(boxes: Boxes3D, index: int) -> Floats:
    """The way an object looks, a unit vector of the camera frame, shape (3,)."""
    angle = boxes.rotation_y[index]
    return np.array([np.cos(angle), 0.0, -np.sin(angle)])


def earlier_pixels(places: Floats, projection: Floats, motion: Floats) -> Floats:
    """Where the earlier image shows places of the current camera frame, u and v, (..., 2)."""
    pixels, depth = project(projection @ motion, places)
    pixels[depth < _NEAREST] = -1e4  # Behind the earlier camera: nowhere in its image.
    return pixels


def _around_boxes(boxes: Boxes3D, projection: Floats) -> Floats:
    corners = box_corners(boxes.location, boxes.dimensions, boxes.rotation_y)
    corners[..., 2] = np.maximum(corners[..., 2], _NEAREST)
    pixels, _ = project(projection, corners)
    return np.concatenate([pixels.min(axis=1), pixels.max(axis=1)], axis=1)


def _samples(regions: Floats, size: tuple[int, int]) -> list[int]:
    """How densely to sample along each side of a crop's pixel, so that nothing is skipped."""
    reduction = (regions[:, 2:] - regions[:, :2]) / np.array(size[::-1])
    return [int(count) for count in np.clip(np.ceil(reduction.max(axis=1)), 1, _MOST_SAMPLES)]


def _pixels(region: Floats, size: tuple[int, int], count: int) -> Floats:
    """u, v of a crop's samples, shape (count * H, count * W, 2)."""
    left, top, right, bottom = region
    rows, columns = (count * side for side in size)
    u = left + (np.arange(columns) + 0.5) * (right - left) / columns
    v = top + (np.arange(rows) + 0.5) * (bottom - top) / rows
    return np.stack(np.meshgrid(u, v), axis=-1)


def places_of(
    pixels: Floats, boxes: Boxes3D, index: int, projection: Floats
) -> tuple[Floats, NDArray[np.bool_]]:
    """Where in the camera frame what pixels show is taken to be.

    Args:
        pixels: u and v, shape (..., 2).
        boxes: The objects.
        index: The index of the object that the pixels show with its surroundings.
        projection: P of the camera, shape (3, 4).

    Returns:
        Places, shape (..., 3), and whether they are on the object's box, shape (...).
    """
    to_ray = np.linalg.inv(projection[:, :3])
    eye = -to_ray @ projection[:, 3]
    rays = np.concatenate([pixels, np.ones((*pixels.shape[:-1], 1))], axis=-1) @ to_ray.T
    location, dimensions = boxes.location[index], boxes.dimensions[index]
    height, width, length = dimensions
    cos, sin = np.cos(boxes.rotation_y[index]), np.sin(boxes.rotation_y[index])
    axes = np.array([[cos, 0.0, -sin], [0.0, 1.0, 0.0], [sin, 0.0, cos]])
    half = 0.5 * np.array([length, height, width])
    middle = location - np.array([0.0, 0.5 * height, 0.0])
    with np.errstate(divide="ignore", invalid="ignore"):
        across = rays @ axes.T
        one, other = ((side - axes @ (eye - middle)) / across for side in (-half, half))
        near, far = np.minimum(one, other), np.maximum(one, other)
        enters = np.maximum(np.maximum(near[..., 0], near[..., 1]), near[..., 2])
        leaves = np.minimum(np.minimum(far[..., 0], far[..., 1]), far[..., 2])
        ground = np.where(rays[..., 1] > 0, (location[1] - eye[1]) / rays[..., 1], np.inf)
    wall = location[2] + 0.5 * np.hypot(length, width) - eye[2]
    on_box = (enters <= leaves) & (leaves > _NEAREST)
    beside = np.minimum(np.where(ground > _NEAREST, ground, np.inf), max(wall, _NEAREST))
    depth = np.where(on_box, np.maximum(enters, _NEAREST), beside)
    return np.asarray(eye + rays * depth[..., None]), on_box


def _sampled(image: Image, pixels: Floats, count: int) -> NDArray[np.float32]:
    """An image at the samples of a crop, averaged over each of its pixels."""
    import cv2

    u, v = (np.clip(pixels[..., axis], -1e4, 1e4).astype(np.float32) for axis in (0, 1))
    found = cv2.remap(image, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)
    size = (found.shape[1] // count, found.shape[0] // count)
    return np.asarray(cv2.resize(found.astype(np.float32), size, interpolation=cv2.INTER_AREA))


def _crops(crops: Iterable[NDArray[np.float32]]) -> Crops:
    return np.asarray(np.round(np.array(list(crops), np.float32)), np.uint8)
