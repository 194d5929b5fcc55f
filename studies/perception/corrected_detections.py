"""What a detector's average precision would be if one kind of error were corrected: why it is lost.

In the spirit of Bolya et al., TIDE (ECCV 2020), for boxes in space: each kind is corrected by the
labels, all else stays as it was found, and the result is scored again.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from avsec_gym.box_overlap import box_iou
from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.json_rows import keyed
from avsec_gym.metrics.average_precision import average_precision
from studies.perception.detection_errors import CATEGORY, Pairs, paired

Correction = Callable[[Boxes3D, Boxes3D, Pairs], Boxes3D]
"""A function from a frame's labels and detections, and which detection means which label, to better
ones."""


@dataclass(frozen=True)
class CorrectedPrecision:
    """AP11 of cars, moderate, IoU 0.7, percent."""

    from_above: float = field(metadata=keyed("bev"))
    in_space: float = field(metadata=keyed("3d"))


def corrected_precision(
    truth: Sequence[Boxes3D], found: Sequence[Boxes3D]
) -> dict[str, CorrectedPrecision]:
    """AP11 of cars (moderate, IoU 0.7, percent) as found, and with each kind of error corrected.

    Args:
        truth: The labels of F frames, DontCare regions included.
        found: The detections of the same frames.

    Returns:
        By kind, in the order of `CORRECTIONS`.
    """
    pairs = [paired(*frame) for frame in zip(truth, found, strict=True)]
    result = {}
    for name, correct in CORRECTIONS.items():
        better = [correct(*frame) for frame in zip(truth, found, pairs, strict=True)]
        scored = average_precision(truth, better, classes=(CATEGORY,))
        bev, space = (round(scored.value(CATEGORY, metric), 4) for metric in ("bev", "3d"))
        result[name] = CorrectedPrecision(bev, space)
    return result


def _nothing(_: Boxes3D, found: Boxes3D, __: Pairs) -> Boxes3D:
    return found


def _depth(truth: Boxes3D, found: Boxes3D, pairs: Pairs) -> Boxes3D:
    """Moved along the line of sight."""
    location = found.location.copy()
    far = truth.location[pairs.label, 2] / location[pairs.detection, 2]
    location[pairs.detection] *= far[:, None]
    return replace(found, location=location)


def _direction(axis: int) -> Correction:
    """Moved across the line of sight: 0 sideways, 1 up or down."""

    def correct(truth: Boxes3D, found: Boxes3D, pairs: Pairs) -> Boxes3D:
        location, true = found.location.copy(), truth.location[pairs.label]
        location[pairs.detection, axis] = true[:, axis] / true[:, 2] * location[pairs.detection, 2]
        return replace(found, location=location)

    return correct


def _yaw(truth: Boxes3D, found: Boxes3D, pairs: Pairs) -> Boxes3D:
    rotation_y = found.rotation_y.copy()
    rotation_y[pairs.detection] = truth.rotation_y[pairs.label]
    return replace(found, rotation_y=rotation_y)


def _size(truth: Boxes3D, found: Boxes3D, pairs: Pairs) -> Boxes3D:
    dimensions = found.dimensions.copy()
    dimensions[pairs.detection] = truth.dimensions[pairs.label]
    return replace(found, dimensions=dimensions)


def _box(truth: Boxes3D, found: Boxes3D, pairs: Pairs) -> Boxes3D:
    """Depth, direction, yaw and size."""
    for correct in (_depth, _direction(0), _direction(1), _yaw, _size):
        found = correct(truth, found, pairs)
    return found


def _score(truth: Boxes3D, found: Boxes3D, pairs: Pairs) -> Boxes3D:
    """The surer, the better the box fits; those that mean nothing come last."""
    score = np.zeros(len(found))
    true, said = truth[pairs.label], found[pairs.detection]
    fit = box_iou(
        true.location, true.dimensions, true.rotation_y,
        said.location, said.dimensions, said.rotation_y,
    )  # fmt: skip
    score[pairs.detection] = 1 + np.diagonal(fit)
    return replace(found, score=score)


def _no_false_alarms(_: Boxes3D, found: Boxes3D, pairs: Pairs) -> Boxes3D:
    return found[np.sort(pairs.detection)]


def _all_but_misses(truth: Boxes3D, found: Boxes3D, pairs: Pairs) -> Boxes3D:
    return _no_false_alarms(truth, _box(truth, found, pairs), pairs)


CORRECTIONS: dict[str, Correction] = {
    "nothing": _nothing,
    "depth": _depth,
    "sideways": _direction(0),
    "upwards": _direction(1),
    "yaw": _yaw,
    "size": _size,
    "whole box": _box,
    "score": _score,
    "false alarms": _no_false_alarms,
    "all but misses": _all_but_misses,
}
"""``false alarms``: detections that mean nothing are dropped.  What is lost even with ``all but
misses`` are cars that no detection means."""
