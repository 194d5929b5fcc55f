"""Ghosts: detections that stand for nothing real."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avsec_gym.box_overlap import ground_rectangles, rectangle_iou
from avsec_gym.boxes import Boxes3D
from avsec_gym.geometry import Floats

SAME = 0.1
"""Intersection over union from above with which a box means a real object."""


def ghosts(
    detections: Boxes3D, truth: Boxes3D, *, overlap: float = SAME, ignored: float = 0.5
) -> NDArray[np.bool_]:
    """Detections that stand for nothing real, shape (N,).

    A ghost overlaps no real object, of whatever category, by more than `overlap` (intersection
    over union from above), so that a box that merely drifted is none; nor does its 2D box lie in a
    region that is not to be cared about (DontCare), where real objects are not labelled.

    Args:
        detections: The detections of one frame.
        truth: The scene's labels, DontCare regions among them.
        overlap: Least intersection over union with a real object.
        ignored: Least share of a 2D box in a DontCare region.
    """
    real = truth.category != "DontCare"
    objects = truth[real]
    iou = iou_from_above(detections, objects)
    result: NDArray[np.bool_] = iou.max(axis=1, initial=0.0) < overlap
    if truth.box2d is not None and detections.box2d is not None and not real.all():
        share = _inside(detections.box2d, truth.box2d[~real])
        result &= share.max(axis=1, initial=0.0) < ignored
    return result


def meant(real: Boxes3D, believed: Boxes3D) -> NDArray[np.bool_]:
    """Which real objects a box means, by an overlap from above of more than `SAME`, shape (N,).

    Args:
        real: N objects.
        believed: The boxes that are believed in.
    """
    result: NDArray[np.bool_] = iou_from_above(real, believed).max(axis=1, initial=0.0) > SAME
    return result


def iou_from_above(boxes: Boxes3D, others: Boxes3D) -> Floats:
    """Intersection over union of the footprints of every pair, shape (N, M)."""
    one, other = (
        ground_rectangles(some.location, some.dimensions, some.rotation_y)
        for some in (boxes, others)
    )
    return rectangle_iou(one, other)


def _inside(boxes: Floats, regions: Floats) -> Floats:
    """Share of each 2D box that lies in each region, shape (N, M)."""
    low = np.maximum(boxes[:, None, :2], regions[None, :, :2])
    high = np.minimum(boxes[:, None, 2:], regions[None, :, 2:])
    common = np.prod(np.maximum(high - low, 0), axis=2)
    return common / np.maximum(np.prod(boxes[:, 2:] - boxes[:, :2], axis=1), 1e-9)[:, None]
