"""Working points and counts, by hand: three cars, what finds them, and what is none."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.metrics.working_point import (
    IN_IMAGE,
    Counts,
    WorkingPoint,
    boxes_right_and_wrong,
    counted,
    working_point,
)

_PLACES = (8.0, 18.0, 28.0)
_BOXES_2D = np.array([[100.0, 150, 260, 300], [500, 160, 580, 230], [800, 165, 850, 215]])


def cars(rows: Sequence[int], scores: Sequence[float], aside: float = 0.0) -> Boxes3D:
    """Some of the three cars, moved aside by so many metres."""
    count, chosen = len(rows), list(rows)
    zero = np.zeros(count)
    location = np.array([[aside, 1.65, _PLACES[row]] for row in rows]).reshape(-1, 3)
    return Boxes3D(
        location, np.tile([1.5, 1.65, 4.0], (count, 1)), np.full(count, -np.pi / 2),
        np.array(scores, float), np.full(count, "Car"), _BOXES_2D[chosen].reshape(-1, 4), zero,
        zero, zero,
    )  # fmt: skip


def joined(*parts: Boxes3D) -> Boxes3D:
    return Boxes3D.concatenate(parts)


_TRUTH = [cars([0, 1], [1, 1]), cars([2], [1])]
_FOUND = [
    joined(cars([0], [0.9]), cars([1], [0.4], aside=5.0)),
    joined(cars([2], [0.7]), cars([1], [0.2], aside=5.0)),
]
"""Two cars of three at 0.9 and 0.7, and what is nowhere near a car at 0.4 and 0.2."""


def test_what_is_found_missed_and_nothing_is_counted() -> None:
    counts = counted(_TRUTH, _FOUND)
    assert counts == Counts(found=2, missed=1, false_alarms=2)
    assert counts.f1 == pytest.approx(2 * 2 / (2 * 2 + 1 + 2))


def test_what_is_missed_is_the_number_of_cars_less_those_found() -> None:
    assert counted([_TRUTH[0]], [cars([0], [0.9])]) == Counts(found=1, missed=1, false_alarms=0)
    assert counted(_TRUTH, [cars([0], [0.9]), cars([], [])]) == Counts(1, 2, 0)


def test_without_labels_and_detections_nothing_is_wrong() -> None:
    assert Counts(0, 0, 0).f1 == 1.0
    assert Counts(0, 2, 0).f1 == 0.0


def test_the_working_point_leaves_out_what_costs_more_than_it_finds() -> None:
    assert working_point(_TRUTH, _FOUND) == WorkingPoint(0.7, 1.0, pytest.approx(2 / 3))


def test_boxes_of_one_score_count_together() -> None:
    tied = [replace(boxes, score=np.full(len(boxes), 0.5)) for boxes in _FOUND]
    assert working_point(_TRUTH, tied) == WorkingPoint(0.5, 0.5, pytest.approx(2 / 3))


def test_a_detector_that_finds_no_car_has_none() -> None:
    wrong = [cars([0], [0.9], aside=5.0), cars([2], [0.8], aside=5.0)]
    assert working_point(_TRUTH, wrong) is None
    # In the image they lie where the cars do.
    assert working_point(_TRUTH, wrong, IN_IMAGE) == WorkingPoint(0.8, 1.0, pytest.approx(2 / 3))
    assert counted(_TRUTH, wrong, IN_IMAGE) == Counts(2, 1, 0)


def test_each_box_is_known_for_a_car_or_for_nothing() -> None:
    place, right, wrong = boxes_right_and_wrong(_TRUTH, _FOUND)
    assert place.tolist() == [0, 2, 1, 3]
    assert right.tolist() == [1, 1, 0, 0]
    assert wrong.tolist() == [0, 0, 1, 1]
