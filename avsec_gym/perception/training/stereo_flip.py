"""The mirrored world: what looks like the mirror image of a stereo pair, as another true pair."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.geometry import Floats, box_corners, project, wrap_angle
from avsec_gym.perception.training.sample import Map, Pixels, StereoSample

_NEAREST_CORNER = 0.1
_ALPHA_UNKNOWN = -10.0


def flipped(sample: StereoSample) -> StereoSample:
    """A sample seen in a mirror: views exchanged, and everything mirrored.

    In the mirror the right camera stands left.  The frame is shifted so that the new left camera
    has the place of the old one, as in all other samples.
    """
    width = sample.size[1]
    shift = _centre_x(sample.left_projection) + _centre_x(sample.right_projection)
    mirror_pixels = np.array([[-1.0, 0, width - 1], [0, 1, 0], [0, 0, 1]])
    mirror_places = np.diag([-1.0, 1, 1, 1])
    mirror_places[0, 3] = shift
    return StereoSample(
        _mirrored(sample.right),
        _mirrored(sample.left),
        # A mirror is its own inverse.
        mirror_pixels @ sample.right_projection @ mirror_places,
        mirror_pixels @ sample.left_projection @ mirror_places,
        _mirrored_map(sample.right_disparity),
        _mirrored_map(sample.left_disparity),
        _flipped_boxes(sample, shift),
    )


def _flipped_boxes(sample: StereoSample, shift: float) -> Boxes3D:
    boxes = sample.truth
    location = boxes.location * np.array([-1.0, 1, 1]) + np.array([shift, 0, 0])
    changes = {"location": location, "rotation_y": wrap_angle(np.pi - boxes.rotation_y)}
    if boxes.alpha is not None:
        known = boxes.alpha > _ALPHA_UNKNOWN
        changes["alpha"] = np.where(known, wrap_angle(np.pi - boxes.alpha), boxes.alpha)
    if boxes.box2d is not None:
        left, top, right, bottom = _boxes_in_right_image(sample).T
        last = sample.size[1] - 1
        changes["box2d"] = np.stack([last - right, top, last - left, bottom], axis=1)
    return replace(boxes, **changes)


def _boxes_in_right_image(sample: StereoSample) -> Floats:
    """2D boxes moved as far as the projected 3D boxes move between the views, shape (N, 4)."""
    boxes, last = sample.truth, sample.size[1] - 1
    assert boxes.box2d is not None
    corners = box_corners(boxes.location, boxes.dimensions, boxes.rotation_y)
    corners[..., 2] = np.maximum(corners[..., 2], _NEAREST_CORNER)
    in_left = project(sample.left_projection, corners)[0][..., 0]
    in_right = project(sample.right_projection, corners)[0][..., 0]
    moved = boxes.box2d.copy()
    for column, extreme, cut in ((0, np.min, boxes.box2d[:, 0] <= 1),
                                 (2, np.max, boxes.box2d[:, 2] >= last - 1)):  # fmt: skip
        there = extreme(in_right, axis=1)
        # Where the left image cuts a box off, its edge is not the object's.
        edge = np.where(cut, there, boxes.box2d[:, column] + there - extreme(in_left, axis=1))
        moved[:, column] = np.clip(edge, 0, last)
    return moved


def _centre_x(projection: Floats) -> float:
    return float(-np.linalg.solve(projection[:, :3], projection[:, 3])[0])


def _mirrored(image: Pixels) -> Pixels:
    return image[:, ::-1].copy()


def _mirrored_map(disparity: Map) -> Map:
    return disparity[:, ::-1].copy()
