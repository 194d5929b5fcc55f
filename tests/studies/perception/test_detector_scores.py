"""Errors, what correcting them gives, distance, working point: of detections made worse by us."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import astuple, replace
from typing import Any

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.geometry import box_corners, project, wrap_angle
from avsec_gym.metrics.working_point import Counts, WorkingPoint, counted, working_point
from avsec_gym.rig import kitti_rig
from studies.perception.corrected_detections import CORRECTIONS, corrected_precision
from studies.perception.detection_errors import car_errors, error_summary, paired
from studies.perception.detector_scores import at_distance, at_occlusion, detector_scores

FRAMES = 60


def cars(places: list[tuple[float, float]], category: str = "Car") -> Boxes3D:
    """Cars as labelled at places right and ahead, with their true 2D boxes."""
    count = len(places)
    location = np.array([[x, 1.65, z] for x, z in places])
    dimensions = np.tile([1.5, 1.65, 4.0], (count, 1))
    rotation_y = np.full(count, -np.pi / 2 + 0.1)
    pixels, _ = project(
        kitti_rig().calibration.projection(2), box_corners(location, dimensions, rotation_y)
    )
    alpha = wrap_angle(rotation_y - np.arctan2(location[:, 0], location[:, 2]))
    zero = np.zeros(count)
    return Boxes3D(
        location, dimensions, rotation_y, np.ones(count), np.full(count, category),
        np.hstack([pixels.min(axis=1), pixels.max(axis=1)]), zero, zero, alpha,
    )  # fmt: skip


@pytest.fixture(scope="module")
def truth() -> list[Boxes3D]:
    return [cars([(-4.0, 8.0 + i % 5), (0.0, 18.0), (5.0, 33.0)]) for i in range(FRAMES)]


def worse(truth: list[Boxes3D], change: Callable[[Boxes3D], dict[str, Any]]) -> list[Boxes3D]:
    return [replace(boxes, **change(boxes)) for boxes in truth]


def farther(boxes: Boxes3D) -> dict[str, Any]:
    """A tenth too far, seen in the same direction."""
    return {"location": boxes.location * 1.1}


CHANGES: dict[str, Callable[[Boxes3D], dict[str, Any]]] = {
    "depth": farther,
    "sideways": lambda boxes: {"location": boxes.location + np.array([0.6, 0, 0])},
    "upwards": lambda boxes: {"location": boxes.location - np.array([0, 0.7, 0])},
    "yaw": lambda boxes: {"rotation_y": boxes.rotation_y + 0.6},
    "size": lambda boxes: {"dimensions": boxes.dimensions * 0.8},
}


@pytest.mark.parametrize("kind", CHANGES)
def test_only_mending_what_is_wrong_helps(truth: list[Boxes3D], kind: str) -> None:
    result = corrected_precision(truth, worse(truth, CHANGES[kind]))
    assert set(result) == set(CORRECTIONS)
    for name, precision in result.items():
        helps = name in (kind, "whole box", "all but misses")
        assert precision.in_space == (pytest.approx(100) if helps else 0), name
    assert (result["nothing"].from_above == pytest.approx(100)) == (kind == "upwards")


def test_errors_are_what_was_put_in(truth: list[Boxes3D]) -> None:
    found = [
        replace(
            boxes,
            location=boxes.location * 1.05 + np.array([0.0, -0.2, 0.0]),
            dimensions=boxes.dimensions + np.array([0.1, -0.2, 0.3]),
            rotation_y=boxes.rotation_y + np.radians(170),
        )
        for boxes in truth
    ]
    everywhere, near, *_ = error_summary(car_errors(truth, found))
    assert everywhere.cars == 3 * FRAMES
    assert near.cars == FRAMES
    assert everywhere.seen == everywhere.reversed == 1.0
    error = {name: spread.median for name, spread in everywhere.errors.items()}
    assert error["depth"] == pytest.approx(0.05 * 18)
    assert near.errors["depth"].median == pytest.approx(0.05 * 10)
    assert error["sideways"] == 0
    assert error["upwards"] == pytest.approx(0.2 / 1.05, abs=1e-4)
    assert error["yaw"] == pytest.approx(-10)
    assert [error[name] for name in ("height", "width", "length")] == pytest.approx(
        [0.1, -0.2, 0.3]
    )


def test_misses_cost_what_nothing_mends_and_false_alarms_are_told(truth: list[Boxes3D]) -> None:
    ghost = cars([(-9.0, 24.0)])
    found = [
        Boxes3D.concatenate([boxes[:0] if i % 2 else boxes, replace(ghost, score=np.array([2.0]))])
        for i, boxes in enumerate(truth)
    ]
    result = corrected_precision(truth, found)
    # Half of all is found: at 11 recall points, up to 0.5.
    best = result["all but misses"].in_space
    assert best == pytest.approx(100 * 6 / 11, abs=1e-3)
    assert result["false alarms"].in_space == result["score"].in_space == best
    assert result["nothing"].in_space < result["whole box"].in_space + 1e-9 < best
    assert error_summary(car_errors(truth, found))[0].seen == 0.5


def test_a_detection_means_one_label_and_the_surest_chooses_first() -> None:
    labels = cars([(0.0, 15.0), (6.0, 15.0)])
    twice = Boxes3D.concatenate([labels[:1], labels[:1], labels[1:]])
    twice = replace(twice, score=np.array([0.2, 0.9, 0.5]))
    pairs = paired(labels, twice)
    assert sorted(zip(pairs.label, pairs.detection, strict=True)) == [(0, 1), (1, 2)]
    everywhere = replace(labels, category=np.array(["Car", "DontCare"]))
    assert paired(everywhere, twice).label.tolist() == [0]
    assert not len(paired(labels, Boxes3D.empty()).label)


def test_another_object_is_no_car_that_was_found() -> None:
    labels = Boxes3D.concatenate([cars([(0.0, 15.0)], "Van"), cars([(6.0, 15.0)])])
    errors = car_errors([labels], [labels[:1]])
    assert errors.distance.tolist() == [15.0]
    assert np.isnan(errors.score).all()


def test_ranges_of_distance_divide_what_there_is(truth: list[Boxes3D]) -> None:
    # A quarter too near: the car at 18 m seems to stand at 13.5 m, overlapping nothing.
    labels = cars([(0.0, 18.0), (0.0, 33.0)])
    found = replace(labels, location=labels.location * [[0.75], [0.97]])
    here, there = at_distance(labels, found, 0.0, 15.0)
    assert here.category.tolist() == ["Van", "Van"]
    assert there.location[:, 2].tolist() == [13.5]
    # 32.01 m overlaps the label at 33 m, whose range counts.
    here, there = at_distance(labels, found, 32.5, 45.0)
    assert here.category.tolist() == ["Van", "Car"]
    assert there.location[:, 2] == pytest.approx([32.01])
    half = [boxes[:2] if i % 2 else boxes for i, boxes in enumerate(truth)]
    rows = detector_scores(truth, half).by_distance
    assert [row.cars for row in rows] == [FRAMES, FRAMES, FRAMES, 0]
    precision = [row.strict["3d"].ap11 for row in rows if row.strict]
    assert precision == pytest.approx([100, 100, 600 / 11])
    assert rows[3].strict is rows[3].loose is None, "too few cars for eleven points of recall"


def test_levels_of_occlusion_divide_the_cars_and_share_false_alarms(truth: list[Boxes3D]) -> None:
    """Of each frame's three cars one is visible, one partly and one largely hidden."""
    hidden = [replace(boxes, occlusion=np.array([0, 1, 2])) for boxes in truth]
    ghost = replace(cars([(-9.0, 24.0)]), score=np.array([2.0]))
    # The largely hidden one is missed in every second frame; a ghost is in each of them.
    found = [
        Boxes3D.concatenate([boxes[:2] if i % 2 else boxes, ghost])
        for i, boxes in enumerate(hidden)
    ]
    here, there = at_occlusion(hidden[0], found[0], 1)
    assert here.category.tolist() == ["Van", "Car", "Van"]
    assert there.location[:, 2].tolist() == [18.0, 24.0]
    rows = detector_scores(hidden, found).by_occlusion
    assert rows is not None
    assert [(row.occlusion, row.cars) for row in rows] == [(level, FRAMES) for level in (0, 1, 2)]
    precision = [row.strict["3d"].ap11 for row in rows if row.strict]
    # All ghosts are surer than all cars: precision is 1/2 up to full recall, and 1/3 up to half.
    assert precision == pytest.approx([50, 50, 100 * 6 / 11 / 3], abs=1e-3)
    clean = detector_scores(hidden, hidden).by_occlusion
    assert clean is not None
    assert [row.strict["3d"].ap11 for row in clean if row.strict] == [100] * 3


def test_scores_of_the_truth_itself(truth: list[Boxes3D]) -> None:
    result = detector_scores(truth, truth, resamples=20)
    for values in result.average_precision["0.7"].values():
        assert values.ap11 == values.ap40 == [100.0] * 3
        assert values.ap40_interval is not None
        assert values.ap40_interval[1] == (100.0, 100.0)
    assert result.working_point == WorkingPoint(score=1.0, precision=1.0, recall=1.0)
    assert result.detections == 3 * FRAMES


def test_the_working_point_is_where_f1_is_best() -> None:
    labels = cars([(-4.0, 12.0), (0.0, 18.0), (5.0, 25.0)])
    right = replace(labels[:2], score=np.array([0.9, 0.4]))
    wrong = replace(cars([(-9.0, 24.0), (9.0, 24.0)]), score=np.array([0.6, 0.1]))
    found = Boxes3D.concatenate([right, wrong])
    # F1 at 0.9: 2/4, at 0.6: 2/5, at 0.4: 4/6, at 0.1: 4/7.
    point = working_point([labels], [found])
    assert point is not None
    assert astuple(point) == pytest.approx((0.4, 2 / 3, 2 / 3))
    counts = counted([labels], [found])
    assert counts == Counts(found=2, missed=1, false_alarms=2)
    assert counts.f1 == pytest.approx(4 / 7)
    assert working_point([labels], [wrong]) is None
    assert working_point([labels], [Boxes3D.empty()]) is None
    tied = replace(found, score=np.full(4, 0.5))
    assert working_point([labels], [tied]) == WorkingPoint(0.5, 0.5, 2 / 3)
