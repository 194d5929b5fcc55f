"""All that labels and detections show of a detector of cars, as JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from avsec_gym.box_overlap import rectangle_iou
from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.json_rows import OPTIONAL, keyed, row_of
from avsec_gym.metrics.average_precision import LOW_IOU, STANDARD_IOU, MinIou, average_precision
from avsec_gym.metrics.average_precision_frames import NEIGHBOURS
from avsec_gym.metrics.working_point import WorkingPoint, working_point
from studies.perception.corrected_detections import CorrectedPrecision, corrected_precision
from studies.perception.detection_errors import (
    CATEGORY,
    DISTANCES,
    LEVEL,
    DistanceErrors,
    car_errors,
    error_summary,
    footprints,
    wanted_cars,
)

IOUS = {"0.7": STANDARD_IOU, "0.5": LOW_IOU}
"""The overlaps from above and in space; in the image always 0.7, as in KITTI's second set of
thresholds."""

FEWEST_CARS = 41
"""The fewest cars: with fewer, KITTI's recall points cannot all be reached, and even a perfect
detector has less than 100 %: a range of distance is left out then."""

_IGNORED = NEIGHBOURS[CATEGORY.lower()].capitalize()


Interval = tuple[float | None, float | None]


@dataclass(frozen=True)
class LevelPrecision:
    """Average precision in one way, easy, moderate and hard, percent; None where unknown."""

    ap11: list[float | None]
    ap40: list[float | None]
    ap11_interval: list[Interval] | None = field(default=None, metadata=OPTIONAL)
    ap40_interval: list[Interval] | None = field(default=None, metadata=OPTIONAL)


@dataclass(frozen=True)
class ModeratePrecision:
    """The same of the moderate level alone."""

    ap11: float | None
    ap40: float | None
    ap11_interval: Interval | None = field(default=None, metadata=OPTIONAL)
    ap40_interval: Interval | None = field(default=None, metadata=OPTIONAL)


Precision = Mapping[str, LevelPrecision]
"""Precision in the image (``2d``), from above (``bev``), in space (``3d``), and of orientation
(``aos``)."""


@dataclass(frozen=True)
class DistancePrecision:
    """The precision of cars at a range of distance, from above and in space; None where too few."""

    near: float
    far: float | None
    """None: no bound."""
    cars: int
    strict: Mapping[str, ModeratePrecision] | None = field(
        default=None, metadata={**keyed("0.7"), **OPTIONAL}
    )
    loose: Mapping[str, ModeratePrecision] | None = field(
        default=None, metadata={**keyed("0.5"), **OPTIONAL}
    )


@dataclass(frozen=True)
class DetectorScores:
    """All that labels and detections show of a detector of cars."""

    detections: int
    average_precision: Mapping[str, Precision]
    """Average precision by `IOUS`."""
    by_distance: Sequence[DistancePrecision]
    errors: Sequence[DistanceErrors]
    corrected: Mapping[str, CorrectedPrecision]
    working_point: WorkingPoint | None


def detector_scores(
    truth: Sequence[Boxes3D], found: Sequence[Boxes3D], resamples: int = 0, seed: int = 0
) -> DetectorScores:
    """Average precision in all ways, by distance, errors, what correcting them would give.

    Args:
        truth: Labels of F frames, DontCare regions included.
        found: Detections of the same frames.
        resamples: Frames are drawn anew so many times for 95 % intervals; 0: none.
        seed: The seed of these draws.
    """

    def at_iou(iou: MinIou) -> Precision:
        return precision(truth, found, iou, resamples, seed)

    return DetectorScores(
        detections=sum(map(len, found)),
        average_precision={name: at_iou(iou) for name, iou in IOUS.items()},
        by_distance=[
            _at_distance(truth, found, near, far, resamples, seed) for near, far in DISTANCES
        ],
        errors=error_summary(car_errors(truth, found)),
        corrected=corrected_precision(truth, found),
        working_point=working_point(truth, found),
    )


def precision(
    truth: Sequence[Boxes3D], found: Sequence[Boxes3D], iou: MinIou, resamples: int, seed: int
) -> Precision:
    """The precision of cars, in all ways; see `average_precision`."""
    result = average_precision(
        truth, found, classes=(CATEGORY,), min_iou=iou, resamples=resamples, seed=seed
    )
    metrics = result.to_json()[CATEGORY]
    return {name: row_of(LevelPrecision, values) for name, values in metrics.items()}


def at_distance(truth: Boxes3D, found: Boxes3D, near: float, far: float) -> tuple[Boxes3D, Boxes3D]:
    """A frame in which only cars of a range of distance are to be found.

    Other cars become neither right nor wrong.  A detection belongs to the range of the label that
    it overlaps most from above, and only where it overlaps none to that of its own.

    Args:
        truth: The labels of the frame.
        found: The detections in the frame.
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
) -> DistancePrecision:
    """At the moderate level; without figures where there are too few cars."""
    frames = [at_distance(*frame, near, far) for frame in zip(truth, found, strict=True)]
    here, there = ([frame[i] for frame in frames] for i in (0, 1))
    cars = sum(int(wanted.sum()) for wanted in wanted_cars(here))
    row = DistancePrecision(near, None if np.isinf(far) else far, cars)
    if cars < FEWEST_CARS:
        return row
    strict, loose = (
        {
            metric: _moderate(values)
            for metric, values in precision(here, there, iou, resamples, seed).items()
            if metric in ("bev", "3d")
        }
        for iou in IOUS.values()
    )
    return replace(row, strict=strict, loose=loose)


def _moderate(values: LevelPrecision) -> ModeratePrecision:
    return ModeratePrecision(
        values.ap11[LEVEL],
        values.ap40[LEVEL],
        values.ap11_interval[LEVEL] if values.ap11_interval else None,
        values.ap40_interval[LEVEL] if values.ap40_interval else None,
    )
