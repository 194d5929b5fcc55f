"""How far the cars that a detector reports are from where they are, and how many it finds at all.

A detection is taken to mean the label that it shares most of the image with.  Boxes in the image
are the easy part of stereo detection, so that errors of depth and size come out as they are,
however large; overlap from above, which average precision asks for, is what suffers from them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.box_overlap import ground_rectangles, rectangle_iou
from avsec_gym.boxes import Boxes3D
from avsec_gym.geometry import Floats, wrap_angle
from avsec_gym.kitti.labels import DONT_CARE
from avsec_gym.metrics.average_precision_frames import COUNTED, LEVELS, label_status, pooled

CATEGORY, LEVEL = "Car", LEVELS.index("moderate")
"""What is looked at."""
DISTANCES = ((0.0, 15.0), (15.0, 30.0), (30.0, 45.0), (45.0, np.inf))
"""Metres ahead."""
ERRORS = ("depth", "sideways", "upwards", "yaw", "height", "width", "length")
"""Metres, yaw in degrees.  ``sideways`` and ``upwards`` are those of the direction in which the box
is seen, at the true depth: an error of depth alone shifts a box along its line of sight."""

_SAME_IN_IMAGE = 0.5
_OVERLAPS = (0.25, 0.5, 0.7)

Integers = NDArray[np.intp]


class Pairs(NamedTuple):
    """K labels of a frame, and the detections that mean them."""

    label: Integers
    detection: Integers


@dataclass(frozen=True, eq=False)
class CarErrors:
    """The errors of the N cars that count, in all frames together."""

    distance: Floats
    """True depth, metres, shape (N,)."""
    overlap: Floats
    """The largest intersection over union from above with any detection, shape (N,)."""
    score: Floats
    """Score of the detection that means the car, NaN where none does, shape (N,)."""
    values: dict[str, Floats]
    """Found minus true, by `ERRORS`; NaN where no detection means the car, shape (N,) each."""
    is_reversed: NDArray[np.bool_]
    """Whether the detection heads the other way; `yaw` does not count that, shape (N,)."""


@dataclass(frozen=True)
class ErrorSpread:
    """One of `ERRORS` over cars; None without cases."""

    median: float | None
    median_size: float | None
    size_of_90: float | None
    """The size that 90 % stay below."""


@dataclass(frozen=True)
class DistanceErrors:
    """What a detector makes of the cars at a range of distance; None where there is no case."""

    near: float
    """Least distance ahead, metres."""
    far: float | None
    """Greatest distance, metres; None: no bound."""
    cars: int
    seen: float | None
    """The share that is found in the image."""
    overlap: Mapping[str, float | None]
    """The shares that some detection overlaps from above by more than 0.25, 0.5 and 0.7."""
    reversed: float | None
    """The share of seen ones whose detection heads the other way."""
    errors: Mapping[str, ErrorSpread]
    """The errors of the seen ones, by `ERRORS`."""


def paired(truth: Boxes3D, found: Boxes3D) -> Pairs:
    """Who is meant: the surest detection chooses first, the label that it covers best in the image.

    Args:
        truth: Labels of a frame, of any category; DontCare regions are never meant.
        found: Detections of the same frame.
    """
    if not len(truth) or not len(found):
        return Pairs(np.zeros(0, np.intp), np.zeros(0, np.intp))
    shared = rectangle_iou(_in_image(found), _in_image(truth))
    shared[:, truth.category == DONT_CARE] = 0.0
    chosen = []
    for detection in np.argsort(-found.score, kind="stable"):
        label = int(shared[detection].argmax())
        if shared[detection, label] >= _SAME_IN_IMAGE:
            chosen.append((label, int(detection)))
            shared[:, label] = 0.0
    labels, detections = np.array(chosen, np.intp).reshape(-1, 2).T
    return Pairs(labels, detections)


def wanted_cars(truth: Sequence[Boxes3D], level: int = LEVEL) -> list[NDArray[np.bool_]]:
    """Which labels of each frame a detector must find at a level, of itself the moderate one."""
    labels = pooled(truth, "labels")
    counts = label_status(labels, CATEGORY, level) == COUNTED
    return np.split(counts, labels.extents.first[1:-1])


def car_errors(
    truth: Sequence[Boxes3D],
    found: Sequence[Boxes3D],
    wanted: Sequence[NDArray[np.bool_]] | None = None,
) -> CarErrors:
    """Compare every car that counts with the detection that means it.

    Args:
        truth: Labels of F frames.
        found: Detections of the same frames.
        wanted: Which labels of each frame count; those of `wanted_cars` if None.
    """
    wanted = wanted_cars(truth) if wanted is None else wanted
    parts = [_errors_of_frame(*frame) for frame in zip(truth, found, wanted, strict=True)]
    columns = [np.concatenate(column) for column in zip(*parts, strict=True)]
    distance, overlap, score, is_reversed, *values = columns
    named = dict(zip(ERRORS, values, strict=True))
    return CarErrors(distance, overlap, score, named, is_reversed.astype(bool))


def error_summary(errors: CarErrors) -> list[DistanceErrors]:
    """The errors over all distances, then for each range of them."""
    rows = []
    for near, far in ((0.0, np.inf), *DISTANCES):
        chosen = (errors.distance >= near) & (errors.distance < far)
        seen = chosen & np.isfinite(errors.score)
        rows.append(
            DistanceErrors(
                near=near,
                far=None if np.isinf(far) else far,
                cars=int(chosen.sum()),
                seen=share(np.isfinite(errors.score[chosen])),
                overlap={
                    f"{least:g}": share(errors.overlap[chosen] > least) for least in _OVERLAPS
                },
                reversed=share(errors.is_reversed[seen]),
                errors={name: _spread(errors.values[name][seen]) for name in ERRORS},
            )
        )
    return rows


def footprints(boxes: Boxes3D) -> Floats:
    """Boxes from above as the rectangles of `avsec_gym.box_overlap`, shape (N, 5)."""
    return ground_rectangles(boxes.location, boxes.dimensions, boxes.rotation_y)


def share(cases: NDArray[np.bool_]) -> float | None:
    """The share of the cases that are true; None without cases."""
    return round(float(cases.mean()), 4) if len(cases) else None


def _in_image(boxes: Boxes3D) -> Floats:
    """2D boxes as the rectangles of `avsec_gym.box_overlap`."""
    assert boxes.box2d is not None, "labels and detections of KITTI files have 2D boxes"
    low, high = boxes.box2d[:, :2], boxes.box2d[:, 2:]
    return np.column_stack([(low + high) / 2, high - low, np.zeros(len(boxes))])


def _errors_of_frame(
    truth: Boxes3D, found: Boxes3D, wanted: NDArray[np.bool_]
) -> tuple[Floats, ...]:
    """The columns of `CarErrors` for the wanted labels of a frame, as floats."""
    own = found[np.char.lower(found.category) == CATEGORY.lower()]
    overlap = np.zeros(len(truth))
    if len(truth) and len(own):
        overlap = rectangle_iou(footprints(truth), footprints(own)).max(axis=1)
    pairs = paired(truth, own)
    columns = np.full((2 + len(ERRORS), len(truth)), np.nan)
    true, said = truth[pairs.label], own[pairs.detection]
    depth, true_depth = said.location[:, 2], true.location[:, 2]
    shift = said.location / depth[:, None] * true_depth[:, None] - true.location
    turn = said.rotation_y - true.rotation_y
    size = said.dimensions - true.dimensions
    columns[:, pairs.label] = (
        said.score,
        np.cos(turn) < 0,
        depth - true_depth,
        shift[:, 0],
        -shift[:, 1],
        np.degrees(wrap_angle(2 * turn) / 2),
        *size.T,
    )
    columns[1] = np.nan_to_num(columns[1])
    return truth.location[wanted, 2], overlap[wanted], *columns[:, wanted]


def _spread(values: Floats) -> ErrorSpread:
    if not len(values):
        return ErrorSpread(None, None, None)
    size = np.abs(values)
    return ErrorSpread(
        median=round(float(np.median(values)), 4),
        median_size=round(float(np.median(size)), 4),
        size_of_90=round(float(np.quantile(size, 0.9)), 4),
    )
