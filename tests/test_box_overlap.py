"""Overlaps of boxes against shapely, and against what geometry demands."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from avsec_gym.box_overlap import (
    box_iou,
    ground_rectangles,
    overlap_area,
    rectangle_iou,
    rectangle_overlap,
)
from avsec_gym.geometry import bird_eye_iou, box_corners, camera_to_ego, rectangle_corners

RECTANGLES = st.builds(
    lambda places, sizes, headings: np.hstack([places, sizes, headings[:, None]]),
    arrays(float, (6, 2), elements=st.floats(-5, 5)),
    arrays(float, (6, 2), elements=st.floats(0.01, 8)),
    arrays(float, 6, elements=st.floats(-7, 7)),
)


def polygons(rectangles: np.ndarray) -> np.ndarray:
    return shapely.polygons(
        rectangle_corners(rectangles[:, [0, 1, 4]], rectangles[:, 2], rectangles[:, 3])
    )


@settings(max_examples=40)
@given(RECTANGLES, RECTANGLES)
def test_common_areas_are_those_of_shapely(one: np.ndarray, other: np.ndarray) -> None:
    expected = shapely.area(shapely.intersection(polygons(one)[:, None], polygons(other)[None, :]))
    areas = rectangle_overlap(one, other)
    assert areas == pytest.approx(expected, abs=1e-9)
    turned = rectangle_overlap(other, one).T
    assert turned == pytest.approx(areas, abs=1e-12)


@settings(max_examples=40)
@given(RECTANGLES, st.floats(-1e4, 1e4), st.floats(-3, 3))
def test_moving_both_changes_nothing(rectangles: np.ndarray, far: float, turn: float) -> None:
    cos, sin = np.cos(turn), np.sin(turn)
    moved = rectangles.copy()
    moved[:, :2] = rectangles[:, :2] @ np.array([[cos, sin], [-sin, cos]]) + far
    moved[:, 4] += turn
    before, after = (rectangle_overlap(r[:3], r[3:]) for r in (rectangles, moved))
    assert after == pytest.approx(before, abs=1e-9)


@pytest.mark.parametrize("heading", [0.0, 0.3, np.pi / 4, np.pi / 2, 3.0])
def test_hand_computed_areas(heading: float) -> None:
    car = np.array([1.0, 2.0, 4.0, 2.0, heading])
    assert overlap_area(car, car) == pytest.approx(8.0, abs=1e-14)
    assert overlap_area(car, np.add(car, [0, 0, 0, 0, np.pi])) == pytest.approx(8.0, abs=1e-14)
    crossed = np.add(car, [0, 0, 0, 0, np.pi / 2])
    assert overlap_area(car, crossed) == pytest.approx(4.0, abs=1e-14)
    ahead = np.add(car, [np.cos(heading), np.sin(heading), 0, 0, 0])
    assert overlap_area(car, ahead) == pytest.approx(6.0, abs=1e-14)
    inside = car * [1, 1, 0.5, 0.5, 1]
    assert overlap_area(car, inside) == pytest.approx(2.0, abs=1e-14)
    beyond = car + 4 * np.array([np.cos(heading), np.sin(heading), 0, 0, 0])
    assert overlap_area(car, beyond) == pytest.approx(0.0, abs=1e-14)
    # Two squares turned by 45 degrees share a regular octagon.
    square, diamond = (
        np.array([0, 0, 2.0, 2.0, heading]),
        np.array([0, 0, 2, 2, heading + np.pi / 4]),
    )
    assert overlap_area(square, diamond) == pytest.approx(8 * (np.sqrt(2) - 1), abs=1e-14)


def test_touching_and_degenerate_rectangles_share_nothing() -> None:
    car = np.array([0.0, 0.0, 4.0, 2.0, 0.0])
    for other in ([4, 0, 4, 2, 0], [0, 2, 4, 2, 0], [0, 0, 0, 0, 1], [0, 0, 5, 0, 0.2]):
        assert rectangle_overlap([car], [other])[0, 0] == pytest.approx(0.0, abs=1e-15)
    assert rectangle_iou([[0, 0, 0, 0, 0]], [[0, 0, 0, 0, 0]])[0, 0] == 0.0
    assert rectangle_iou(np.zeros((0, 5)), [car]).shape == (0, 1)


def boxes(random: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    location = random.uniform([-3, 1, 9], [3, 2, 15], (count, 3))
    return location, random.uniform(1, 4, (count, 3)), random.uniform(-4, 4, count)


def test_the_ground_of_a_box_is_its_bottom_face() -> None:
    location, dimensions, rotation_y = boxes(np.random.default_rng(0), 20)
    ground = polygons(ground_rectangles(location, dimensions, rotation_y))
    bottoms = shapely.polygons(box_corners(location, dimensions, rotation_y)[:, :4, [0, 2]])
    assert shapely.area(shapely.symmetric_difference(ground, bottoms)).max() < 1e-12


def test_iou_from_above_is_that_of_the_planning_frame() -> None:
    one, other = (boxes(np.random.default_rng(seed), 20) for seed in (1, 2))
    expected = bird_eye_iou(
        camera_to_ego(one[0], one[2]), one[1][:, [2, 1]],
        camera_to_ego(other[0], other[2]), other[1][:, [2, 1]],
    )  # fmt: skip
    result = rectangle_iou(ground_rectangles(*one), ground_rectangles(*other))
    assert result == pytest.approx(expected, abs=1e-12)
    assert (expected > 0.1).any()


def test_iou_in_space_against_counting_points() -> None:
    """A million random points: their share in both boxes over that in either."""
    random = np.random.default_rng(3)
    one, other = boxes(random, 3), boxes(random, 3)
    points = random.uniform([-6, -3, 6], [6, 2, 18], (1_000_000, 3))

    def inside(box: tuple[np.ndarray, np.ndarray, np.ndarray], i: int) -> np.ndarray:
        (x, y, z), (height, width, length), angle = box[0][i], box[1][i], box[2][i]
        dx, dy, dz = points[:, 0] - x, points[:, 1] - y, points[:, 2] - z
        along = np.cos(angle) * dx - np.sin(angle) * dz
        across = np.sin(angle) * dx + np.cos(angle) * dz
        return (abs(along) < length / 2) & (abs(across) < width / 2) & (dy < 0) & (dy > -height)

    iou = box_iou(*one, *other)
    for i in range(3):
        for j in range(3):
            a, b = inside(one, i), inside(other, j)
            assert iou[i, j] == pytest.approx((a & b).sum() / (a | b).sum(), abs=0.01)
    assert (iou > 0.05).sum() > 2
    assert box_iou(*one, *one).diagonal() == pytest.approx(1.0, abs=1e-12)
