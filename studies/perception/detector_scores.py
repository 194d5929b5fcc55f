"""All that labels and detections say of a detector of cars, as JSON."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from avsec_gym.box_overlap import rectangle_iou
from avsec_gym.boxes import Boxes3D
from avsec_gym.metrics.average_precision import LOW_IOU, STANDARD_IOU, MinIou, average_precision
from avsec_gym.metrics.average_precision_frames import NEIGHBOURS
from avsec_gym.metrics.working_point import working_point
from studies.perception.corrected_detections import corrected_precision
from studies.perception.detection_errors import (
    CATEGORY,
    DISTANCES,
    LEVEL,
    car_errors,
    error_summary,
    footprints,
    wanted_cars,
)

IOUS = {"0.7": STANDARD_IOU, "0.5": LOW_IOU}
"""From above and in space; in the image always 0.7, as in KITTI's second set of thresholds."""

FEWEST_CARS = 41
"""With fewer, KITTI's recall points cannot all be reached, and even a perfect detector has less
than 100 %: a range of distance is left out then."""

_IGNORED = NEIGHBOURS[CATEGORY.lower()].capitalize()


def detector_scores(
    truth: Sequence[Boxes3D], found: Sequence[Boxes3D], resamples: int = 0, seed: int = 0
) -> dict[str, Any]:
    """Average precision in all ways, by distance, errors, what mending them would give.

    Args:
        truth: Labels of F frames, DontCare regions included.
        found: Detections of the same frames.
        resamples: Frames are drawn anew so many times for 95 % intervals; 0: none.
        seed: The seed of these draws.
    """
    point = working_point(truth, found)

    def precision(iou: MinIou) -> dict[str, Any]:
        return _precision(truth, found, iou, resamples, seed)

    return {
        "detections": sum(map(len, found)),
        "average_precision": {name: precision(iou) for name, iou in IOUS.items()},
        "by_distance": [
            _at_distance(truth, found, near, far, resamples, seed) for near, far in DISTANCES
        ],
        "errors": error_summary(car_errors(truth, found)),
        "corrected": corrected_precision(truth, found),
        "working_point": None if point is None else point._asdict(),
    }


def at_distance(truth: Boxes3D, found: Boxes3D, near: float, far: float) -> tuple[Boxes3D, Boxes3D]:
    """A frame in which only cars of a range of distance are to be found.

    Other cars become neither right nor wrong.  A detection belongs to the range of the label that
    it overlaps most from above, and only where it overlaps none to that of its own.

    Args:
        truth: Labels.
        found: Detections.
        near: The least distance ahead, metres.
        far: The greatest distance ahead, metres, not included.
    """
    distance, own = truth.location[:, 2], found.location[:, 2].copy()
    if len(truth) and len(found):
        shared = rectangle_iou(footprints(found), footprints(truth))
        touches = shared.max(axis=1) > 0
        own[touches] = distance[shared.argmax(axis=1)][touches]
    elsewhere = ~((distance >= near) & (distance < far)) & (truth.category == CATEGORY)
    category = np.where(elsewhere, _IGNORED, truth.category)
    return replace(truth, category=category), found[(own >= near) & (own < far)]


def _at_distance(
    truth: Sequence[Boxes3D],
    found: Sequence[Boxes3D],
    near: float,
    far: float,
    resamples: int,
    seed: int,
) -> dict[str, Any]:
    """At the moderate level; without figures where there are too few cars."""
    frames = [at_distance(*frame, near, far) for frame in zip(truth, found, strict=True)]
    here, there = ([frame[i] for frame in frames] for i in (0, 1))
    cars = sum(int(wanted.sum()) for wanted in wanted_cars(here))
    result: dict[str, Any] = {"near": near, "far": None if np.isinf(far) else far, "cars": cars}
    for name, iou in IOUS.items() if cars >= FEWEST_CARS else ():
        every = _precision(here, there, iou, resamples, seed)
        result[name] = {
            metric: {points: values[LEVEL] for points, values in every[metric].items()}
            for metric in ("bev", "3d")
        }
    return result


def _precision(
    truth: Sequence[Boxes3D], found: Sequence[Boxes3D], iou: MinIou, resamples: int, seed: int
) -> dict[str, Any]:
    """Of cars; see `AveragePrecision.to_json`."""
    result = average_precision(
        truth, found, classes=(CATEGORY,), min_iou=iou, resamples=resamples, seed=seed
    )
    return result.to_json()[CATEGORY]
