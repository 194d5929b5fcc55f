"""Objects that one sensor sees and another does not: the object-level baseline (section 3.3.3).

The thesis extracts "object-level features" from two sensors and detects attacks "by measuring the
mismatches between the two sets", with IoU 0.5 and 0.7 "for determining feature mismatches"; how
boxes of two sensors are compared it does not state.  Here they are compared in a camera's image:

- A box in space is projected into the image, and clipped to it.
- A box in another camera's image may stand anywhere farther left than in the reference's, by up to
  the disparity of what is 3.5 m away: its depth is unknown, and a near car's two boxes have
  little in common as they are.
- Of all ways to pair boxes the one with the fewest mismatches counts.
- Boxes lower than 25 pixels may have a partner but are no mismatch: far cars are seen by some
  sensors only.  KITTI's benchmark leaves them out, too.  Nor is a box at an image's edge, which the
  other camera would not show if it were near.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.optimize import linear_sum_assignment

from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import Calibration
from avsec_gym.geometry import Floats, box_corners, project
from avsec_gym.metrics.average_precision_frames import LEVELS, MIN_HEIGHT
from avsec_gym.validation.evidence.pair_depth import PairDepth

LOWEST = MIN_HEIGHT[LEVELS.index("moderate")]
"""Pixels; lower boxes are no mismatches."""
_NEAR = 0.1
"""Metres: corners behind the camera are projected as if this far before it."""


def mismatches(
    first: Boxes3D,
    second: Boxes3D,
    least_iou: float,
    reach: float = 0.0,
    width: float = np.inf,
) -> int:
    """How many boxes of either set have no partner in the other.

    Args:
        first: Boxes in an image, with `box2d`.
        second: Boxes in the same image, or in that of a camera farther right.
        least_iou: Partners are of one category and have more than this in common.
        reach: The largest disparity between the two images, pixels; 0: they are one.
        width: The width of the images, pixels.

    Example:
        >>> from avsec_gym.perception.detectors.image_detector import image_boxes
        >>> box2d = np.array([[0.0, 0, 50, 50], [90, 0, 140, 40]])
        >>> cars = image_boxes(box2d, np.ones(2), ["Car", "Car"])
        >>> mismatches(cars, cars[:1], 0.5)
        1
    """
    one, other = _box2d(first), _box2d(second)
    asked = _heights(one) >= LOWEST, _heights(other) >= LOWEST
    if reach:
        asked = asked[0] & (one[:, 0] >= reach), asked[1] & (other[:, 2] <= width - reach)
    partners = _image_iou(one, other, reach) > least_iou
    partners &= first.category[:, None] == second.category[None, :]
    # What a pair is worth: the mismatches that it spares.
    worth = partners * (asked[0][:, None].astype(int) + asked[1])
    chosen = linear_sum_assignment(worth, maximize=True)
    return int(asked[0].sum() + asked[1].sum() - worth[chosen].sum())


def disparity_reach(calibration: Calibration, left: int, right: int) -> float:
    """The disparity of what is as near as matchers look, pixels."""
    return calibration.focal_length(left) * calibration.baseline(left, right) / PairDepth.nearest


def boxes_seen_by(boxes: Boxes3D, projection: Floats, size: tuple[int, int]) -> Boxes3D:
    """Boxes in space as a camera shows them; those that it does not show are left out.

    Args:
        boxes: The boxes, in the camera frame.
        projection: The projection of the camera, shape (3, 4).
        size: Height and width of its image, to which 2D boxes are clipped.
    """
    corners = box_corners(boxes.location, boxes.dimensions, boxes.rotation_y)
    corners[..., 2] = np.maximum(corners[..., 2], _NEAR)
    pixels, _ = project(projection, corners)
    pixels = np.clip(pixels, 0.0, [size[1] - 1.0, size[0] - 1.0])
    box2d = np.concatenate([pixels.min(axis=1), pixels.max(axis=1)], axis=-1)
    seen = (boxes.location[:, 2] > 0) & (box2d[:, 2:] > box2d[:, :2]).all(axis=1)
    return replace(boxes, box2d=box2d)[seen]


def _image_iou(first: Floats, second: Floats, reach: float) -> Floats:
    """Of every pair of boxes, the second one moved right by what fits best, shape (N, M)."""
    one, other = first[:, None], second[None, :]
    # Two intervals have most in common where their middles meet.
    apart = (one[..., 0] + one[..., 2] - other[..., 0] - other[..., 2]) / 2
    moved = np.clip(apart, 0.0, reach)
    width = np.minimum(one[..., 2], other[..., 2] + moved) - np.maximum(
        one[..., 0], other[..., 0] + moved
    )
    height = np.minimum(one[..., 3], other[..., 3]) - np.maximum(one[..., 1], other[..., 1])
    common = np.maximum(width, 0.0) * np.maximum(height, 0.0)
    union = _areas(one) + _areas(other) - common
    return np.divide(common, union, out=np.zeros_like(common), where=union > 0)


def _areas(boxes: Floats) -> Floats:
    return np.asarray((boxes[..., 2:] - boxes[..., :2]).prod(axis=-1))


def _heights(box2d: Floats) -> Floats:
    return box2d[:, 3] - box2d[:, 1]


def _box2d(boxes: Boxes3D) -> Floats:
    return np.zeros((0, 4)) if boxes.box2d is None else boxes.box2d
