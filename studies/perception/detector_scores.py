"""All that labels and detections show of a detector of cars, as JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from avsec_gym.box_overlap import rectangle_iou
from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.json_rows import OPTIONAL, keyed, row_of
from avsec_gym.metrics.average_precision import LOW_IOU, STANDARD_IOU, MinIou, average_precision
from avsec_gym.metrics.average_precision_frames import LEVELS, NEIGHBOURS
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

_HARD = LEVELS.index("hard")
_OCCLUSIONS = (0, 1, 2)
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
class LimitedPrecision:
    """The same of one level alone."""

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
    strict: Mapping[str, LimitedPrecision] | None = field(
        default=None, metadata={**keyed("0.7"), **OPTIONAL}
    )
    loose: Mapping[str, LimitedPrecision] | None = field(
        default=None, metadata={**keyed("0.5"), **OPTIONAL}
    )


@dataclass(frozen=True)
class OcclusionPrecision:
    """The precision of cars that are hidden so much, by KITTI's hard level; None where too few."""

    occlusion: int
    """KITTI's level: 0 fully visible, 1 partly, 2 largely occluded."""
    cars: int
    strict: Mapping[str, LimitedPrecision] | None = field(
        default=None, metadata={**keyed("0.7"), **OPTIONAL}
    )
    loose: Mapping[str, LimitedPrecision] | None = field(
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
    by_occlusion: Sequence[OcclusionPrecision] | None = field(default=None, metadata=OPTIONAL)
    """None in earlier results."""


def detector_scores(
    truth: Sequence[Boxes3D], found: Sequence[Boxes3D], resamples: int = 0, seed: int = 0
) -> DetectorScores:
    """Average precision in all ways, by distance and occlusion, errors, what mending them gives.

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
        by_occlusion=[
            _at_occlusion(truth, found, occlusion, resamples, seed) for occlusion in _OCCLUSIONS
        ],
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

    A detection that overlaps no label belongs to the range of its own distance.  See `_only`.

    Args:
        truth: The labels of the frame.
        found: The detections in the frame.
        near: The least distance ahead, metres.
        far: The greatest distance ahead, metres, not included.
    """

    def inside(boxes: Boxes3D) -> NDArray[np.bool_]:
        distance = boxes.location[:, 2]
        return (distance >= near) & (distance < far)

    return _only(truth, found, inside(truth), inside(found))


def at_occlusion(truth: Boxes3D, found: Boxes3D, occlusion: int) -> tuple[Boxes3D, Boxes3D]:
    """A frame in which only cars are to be found that are hidden so much.

    A detection that overlaps no label is a false alarm at every level.  See `_only`.

    Args:
        truth: The labels of the frame.
        found: The detections in the frame.
        occlusion: KITTI's level.
    """
    assert truth.occlusion is not None, "labels have it"
    return _only(truth, found, truth.occlusion == occlusion, np.ones(len(found), bool))


def _only(
    truth: Boxes3D, found: Boxes3D, wanted: NDArray[np.bool_], kept: NDArray[np.bool_]
) -> tuple[Boxes3D, Boxes3D]:
    """A frame in which only some cars are to be found.

    Other cars become neither right nor wrong, and with them detections that overlap one of them
    most from above.

    Args:
        truth: M labels of the frame.
        found: N detections in the frame.
        wanted: Which labels are to be found, shape (M,).
        kept: Which detections count that overlap no label, shape (N,).
    """
    if len(truth) and len(found):
        shared = rectangle_iou(footprints(found), footprints(truth))
        touches = shared.max(axis=1) > 0
        kept = np.where(touches, wanted[shared.argmax(axis=1)], kept)
    elsewhere = ~wanted & (truth.category == CATEGORY)
    category = np.where(elsewhere, _IGNORED, truth.category)
    return replace(truth, category=category), found[kept]


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
    cars = _count(frames, LEVEL)
    row = DistancePrecision(near, None if np.isinf(far) else far, cars)
    if cars < FEWEST_CARS:
        return row
    strict, loose = _of_level(frames, LEVEL, resamples, seed)
    return replace(row, strict=strict, loose=loose)


def _at_occlusion(
    truth: Sequence[Boxes3D],
    found: Sequence[Boxes3D],
    occlusion: int,
    resamples: int,
    seed: int,
) -> OcclusionPrecision:
    """At the hard level, the only one at which all of them count; without figures if too few."""
    frames = [at_occlusion(*frame, occlusion) for frame in zip(truth, found, strict=True)]
    row = OcclusionPrecision(occlusion, _count(frames, _HARD))
    if row.cars < FEWEST_CARS:
        return row
    strict, loose = _of_level(frames, _HARD, resamples, seed)
    return replace(row, strict=strict, loose=loose)


def _count(frames: Sequence[tuple[Boxes3D, Boxes3D]], level: int) -> int:
    """The number of cars to find."""
    return sum(int(wanted.sum()) for wanted in wanted_cars([truth for truth, _ in frames], level))


def _of_level(
    frames: Sequence[tuple[Boxes3D, Boxes3D]], level: int, resamples: int, seed: int
) -> list[Mapping[str, LimitedPrecision]]:
    """Precision from above and in space at both of `IOUS`."""
    truth, found = ([frame[i] for frame in frames] for i in (0, 1))
    return [
        {
            metric: _at_level(values, level)
            for metric, values in precision(truth, found, iou, resamples, seed).items()
            if metric in ("bev", "3d")
        }
        for iou in IOUS.values()
    ]


def _at_level(values: LevelPrecision, level: int) -> LimitedPrecision:
    return LimitedPrecision(
        values.ap11[level],
        values.ap40[level],
        values.ap11_interval[level] if values.ap11_interval else None,
        values.ap40_interval[level] if values.ap40_interval else None,
    )
