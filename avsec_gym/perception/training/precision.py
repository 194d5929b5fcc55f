"""Average precision of a validation, as the metrics that trainings report."""

from __future__ import annotations

from collections.abc import Sequence

from avsec_gym.boxes import Boxes3D
from avsec_gym.metrics.average_precision import (
    LOW_IOU,
    STANDARD_IOU,
    MinIou,
    average_precision,
)

_EASIER = "iou50"
"""Measures of this ending take the easier overlaps."""


def half_in_images(category: str) -> MinIou:
    """Easier overlaps of detectors of images: `LOW_IOU` is no easier there.

    Args:
        category: Class such as ``Car``.
    """
    return {category: (0.5, 0.5, 0.5)}


def precision(
    labels: Sequence[Boxes3D],
    found: Sequence[Boxes3D],
    category: str,
    measures: Sequence[str],
    easier: MinIou = LOW_IOU,
) -> dict[str, float]:
    """Average precision of a category, percent.

    Args:
        labels: What is there, for each frame.
        found: Detections of the same frames.
        category: Class such as ``Car``.
        measures: Names such as ``3d_ap11``, ``bev_ap40``, ``2d_ap11_hard`` and ``3d_ap11_iou50``:
            the view, the recall points, and the level (moderate unless named) or `easier` overlaps.
        easier: Overlaps that count in measures on ``iou50``.

    Returns:
        In the order of the measures, with the category before each name.
    """
    overlaps = {False: STANDARD_IOU, True: easier}
    needed = {measure.endswith(_EASIER) for measure in measures}
    scores = {
        is_easier: average_precision(
            labels, found, classes=(category,), min_iou=overlaps[is_easier]
        )
        for is_easier in needed
    }
    result = {}
    for measure in measures:
        view, points, *rest = measure.split("_")
        is_easier = rest == [_EASIER]
        level = rest[0] if rest and not is_easier else "moderate"
        result[f"{category}_{measure}"] = scores[is_easier].value(
            category, view, level, recall_points=int(points.removeprefix("ap"))
        )
    return result
