"""Average precision of a single scene.

KITTI's looks at precision at 11 or 40 recalls, which a scene of three cars does not have: found or
not, it comes out nearly the same.  Here every car of the scene is a recall of its own.
"""

from __future__ import annotations

import numpy as np

from avsec_gym.box_overlap import box_iou
from avsec_gym.boxes import Boxes3D
from avsec_gym.geometry import Floats
from avsec_gym.metrics.ghosts import ghosts


def scene_precision(labels: Boxes3D, seen: Boxes3D, min_iou: float, category: str = "Car") -> float:
    """The area under the precision-recall curve of a scene's cars, interpolated at all points.

    Args:
        labels: The labels of the scene, DontCare regions among them; all cars count, however far.
        seen: The detections; cars count, and those in DontCare regions are not held against it.
        min_iou: Least intersection over union of volumes with which a detection finds a car.
        category: The class that counts, if it is not that of cars.

    Returns:
        From 0 to 1; NaN without a car.
    """
    cars, found = labels[labels.category == category], seen[seen.category == category]
    if not len(cars):
        return np.nan
    order = np.argsort(-found.score, kind="stable")
    found = found[order]
    overlap = _volumes(cars, found)
    # The surest detection first takes the car that it overlaps most, of those that are left.
    hit = np.zeros(len(found), bool)
    for j in range(len(found)):
        i = int(overlap[:, j].argmax())
        if overlap[i, j] >= min_iou:
            hit[j], overlap[i] = True, 0.0
    # Far from any label, but in a region that has none: neither right nor wrong.
    near = _volumes(cars, found).max(axis=0, initial=0.0) > 0
    counted = hit | near | ghosts(found, labels)
    hits = np.cumsum(hit[counted])
    precision = hits / np.arange(1, len(hits) + 1)
    best = np.maximum.accumulate(precision[::-1])[::-1]
    return float(best[hit[counted]].sum() / len(cars))


def _volumes(one: Boxes3D, other: Boxes3D) -> Floats:
    """Intersection over union of volumes of every pair, shape (N, M)."""
    return box_iou(
        one.location,
        one.dimensions,
        one.rotation_y,
        other.location,
        other.dimensions,
        other.rotation_y,
    )
