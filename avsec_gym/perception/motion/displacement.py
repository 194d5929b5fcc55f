"""How far objects have driven between two frames, if they have: the way that explains both best."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import Image
from avsec_gym.geometry import Floats
from avsec_gym.perception.motion.crops import earlier_pixels, heading, places_of

LEAST = 0.2
"""Metres of the shortest way that is tried."""

_WAYS = LEAST * 1.15 ** np.arange(28)
"""Metres, up to 30 m/s between frames 0.3 s apart."""
_HALVINGS = 3
_GRID = 32
"""Points of a box's image that are compared, along each side."""
_MOST_DIFFERENCE = 60.0
"""Grey levels; more of it, as of what another object hides, counts no more."""


def likeliest_ways(
    now: Image,
    before: Image,
    regions: Floats,
    boxes: Boxes3D,
    projection: Floats,
    motion: Floats,
) -> Floats:
    """The ways along their headings, at least `LEAST` either way, by which objects fit best.

    Args:
        now: The current image.
        before: The earlier one.
        regions: The regions of the current image, around the objects, shape (N, 4).
        boxes: N objects, as they are now.
        projection: P of the camera, shape (3, 4).
        motion: The motion of `ego_motion`, shape (4, 4).

    Returns:
        Metres driven since, negative backwards, shape (N,).
    """
    images = [_grey(image) for image in (now, before)]
    found = [
        _likeliest_way(images, region, boxes, index, projection, motion)
        for index, region in enumerate(regions)
    ]
    return np.array(found, float)


def _likeliest_way(
    images: list[NDArray[np.float32]],
    region: Floats,
    boxes: Boxes3D,
    index: int,
    projection: Floats,
    motion: Floats,
) -> float:
    import cv2

    # A grid of pixels of the region, and the places of the box's surface that they show.
    left, top, right, bottom = region
    share = (np.arange(_GRID) + 0.5) / _GRID
    grid = np.meshgrid(left + share * (right - left), top + share * (bottom - top))
    pixels = np.stack(grid, axis=-1).reshape(-1, 2)
    places, on_box = places_of(pixels, boxes, index, projection)
    if not on_box.any():
        return LEAST
    # The points are as far apart as the image is blurred: none falls between them.
    blur = max((right - left) / _GRID / 2, (bottom - top) / _GRID / 2, 0.5)
    now, before = (
        np.asarray(cv2.GaussianBlur(image, (0, 0), blur), np.float32) for image in images
    )
    pixels, places = pixels[on_box], places[on_box]
    seen = _at(now, pixels[None])[0]

    def misfit(ways: Floats) -> Floats:
        moved = places - ways[:, None, None] * heading(boxes, index)
        there = _at(before, earlier_pixels(moved, projection, motion))
        # Less the median, for another exposure; bounded, for what came before the object.
        difference = there - seen
        difference = np.abs(difference - np.median(difference, axis=1, keepdims=True))
        return np.asarray(np.minimum(difference, _MOST_DIFFERENCE).mean(axis=1))

    # The best of a coarse grid of ways, refined by smaller and smaller steps about it.
    ways = np.concatenate([-_WAYS[::-1], _WAYS])
    best = float(ways[np.argmin(misfit(ways))])
    step = 0.075 * abs(best)
    for _ in range(_HALVINGS):
        near = best + step * np.array([-1.0, 0.0, 1.0])
        near = near[np.abs(near) >= LEAST]
        best = float(near[np.argmin(misfit(near))])
        step /= 2
    return best


def _at(image: NDArray[np.float32], pixels: Floats) -> NDArray[np.float32]:
    import cv2

    u, v = (np.clip(pixels[..., axis], -1e4, 1e4).astype(np.float32) for axis in (0, 1))
    return np.asarray(cv2.remap(image, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT))


def _grey(image: Image) -> NDArray[np.float32]:
    import cv2

    return np.asarray(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), np.float32)
