"""What a detector's scores are worth: where they find most, and how often each is right."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from avsec_gym.boxes import Boxes3D
from avsec_gym.geometry import Floats
from avsec_gym.metrics.average_precision_frames import (
    COUNTED,
    LEVELS,
    detection_status,
    label_status,
    pooled,
)
from avsec_gym.metrics.average_precision_matching import Events, match, overlaps

CATEGORY, LEVEL = "Car", LEVELS.index("moderate")
"""What is counted."""
MIN_IOU = 0.5
"""The overlap from above: a box that is right to a metre or so; or in the image."""
IN_IMAGE, FROM_ABOVE = 0, 1
"""Where boxes are compared."""


@dataclass(frozen=True)
class WorkingPoint:
    """Where a detector finds most for its false alarms (best F1)."""

    score: float
    """Score of the boxes that count, or more."""
    precision: float
    recall: float


@dataclass(frozen=True)
class Counts:
    """Counts of cars (moderate, `MIN_IOU`), by KITTI's rules."""

    found: int
    missed: int
    false_alarms: int

    @property
    def f1(self) -> float:
        """Harmonic mean of precision and recall; 1 without labels and detections."""
        right, wrong = 2 * self.found, self.missed + self.false_alarms
        return right / (right + wrong) if right + wrong else 1.0


def working_point(
    truth: Sequence[Boxes3D], found: Sequence[Boxes3D], seen: int = FROM_ABOVE
) -> WorkingPoint | None:
    """The working point of a detector on F frames; None where it finds no car at all.

    Args:
        truth: Labels of each frame.
        found: Detections in the same frames.
        seen: `FROM_ABOVE` or `IN_IMAGE`.
    """
    events, cars = _events(truth, found, seen)
    hits = np.cumsum(events.true_positives)
    detected = hits + np.cumsum(events.false_positives)
    f1 = 2 * hits / np.maximum(detected + cars, 1)
    # All boxes of one score count together.
    f1[np.diff(events.score, append=-np.inf) == 0] = 0.0
    if not f1.any():
        return None
    best = int(f1.argmax())
    return WorkingPoint(
        float(events.score[best]), float(hits[best] / detected[best]), float(hits[best] / cars)
    )


def counted(truth: Sequence[Boxes3D], found: Sequence[Boxes3D], seen: int = FROM_ABOVE) -> Counts:
    """What is right and wrong, each detection taken for real.

    Args:
        truth: Labels of F frames.
        found: Detections in the same frames.
        seen: `FROM_ABOVE` or `IN_IMAGE`.
    """
    events, cars = _events(truth, found, seen)
    hits = int(events.true_positives.sum())
    return Counts(hits, cars - hits, int(events.false_positives.sum()))


def boxes_right_and_wrong(
    truth: Sequence[Boxes3D], found: Sequence[Boxes3D], seen: int = FROM_ABOVE
) -> tuple[NDArray[np.intp], Floats, Floats]:
    """Which boxes are cars, and which are nothing.

    Args:
        truth: Labels of F frames.
        found: Detections in the same frames.
        seen: `FROM_ABOVE` or `IN_IMAGE`.

    Returns:
        Places among all that was found, frame after frame, of the E boxes that count, best first;
        1 where one is a car, and 1 where it is nothing, shape (E,) each.
    """
    score = np.concatenate([boxes.score for boxes in found])
    worst_first = np.argsort(score, kind="stable")
    # A score of its own for each box, in the same order, identifies the box of an event.
    rank = np.empty(len(score))
    rank[worst_first] = np.arange(len(score))
    ends = np.cumsum([len(boxes) for boxes in found])[:-1]
    ranked = [
        replace(boxes, score=own) for boxes, own in zip(found, np.split(rank, ends), strict=True)
    ]
    events, _ = _events(truth, ranked, seen)
    right, wrong = (
        np.maximum(each, 0).astype(float)
        for each in (events.true_positives, events.false_positives)
    )
    return worst_first[events.score.astype(np.intp)], right, wrong


def _events(
    truth: Sequence[Boxes3D], found: Sequence[Boxes3D], seen: int = FROM_ABOVE
) -> tuple[Events, int]:
    """What changes at each score, best first, and how many cars there are to find."""
    labels, detections = pooled(truth, "labels"), pooled(found, "detections")
    wanted = label_status(labels, CATEGORY, LEVEL)
    given = detection_status(detections, CATEGORY, LEVEL)
    common = overlaps(labels, detections)
    events = match(labels, detections, common, wanted, given, seen, MIN_IOU)
    return events, int((wanted == COUNTED).sum())
