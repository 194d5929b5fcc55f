"""Frames, rotations, rectangles and boxes."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from avsec_gym.geometry import (
    bird_eye_iou,
    box_corners,
    camera_to_ego,
    ego_to_camera,
    project,
    rectangle_corners,
    rectangle_polygons,
    transform_points,
    wrap_angle,
)

angles = st.floats(-20, 20)
coordinates = st.floats(-100, 100)
sizes = st.floats(0.1, 20)


@given(angles)
def test_wrapped_angle_is_the_same_direction(angle: float) -> None:
    wrapped = float(wrap_angle(angle))
    assert -np.pi <= wrapped < np.pi
    assert np.allclose([np.cos(wrapped), np.sin(wrapped)], [np.cos(angle), np.sin(angle)])


@given(hnp.arrays(float, (5, 3), elements=coordinates), hnp.arrays(float, 5, elements=angles))
def test_camera_and_ego_frames_are_inverse(location: np.ndarray, rotation_y: np.ndarray) -> None:
    poses = camera_to_ego(location, rotation_y)
    back, rotation_back = ego_to_camera(poses, location[:, 1])
    np.testing.assert_allclose(back, location)
    np.testing.assert_allclose(np.cos(rotation_back), np.cos(rotation_y), atol=1e-9)
    np.testing.assert_allclose(np.sin(rotation_back), np.sin(rotation_y), atol=1e-9)


def test_a_car_ahead_that_drives_away_has_heading_zero() -> None:
    """KITTI: rotation_y is 0 for a car facing right, -pi/2 for one facing away."""
    pose = camera_to_ego([2.0, 1.6, 15.0], -np.pi / 2)
    np.testing.assert_allclose(pose, [15.0, -2.0, 0.0])
    assert camera_to_ego([0.0, 0.0, 1.0], 0.0)[2] == pytest.approx(-np.pi / 2)


@given(coordinates, coordinates, angles, sizes, sizes)
def test_rectangle_has_its_sides_and_area(
    x: float, y: float, heading: float, length: float, width: float
) -> None:
    corners = rectangle_corners([x, y, heading], np.array(length), np.array(width))
    sides = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)
    np.testing.assert_allclose(sides, [length, width, length, width], rtol=1e-6)
    polygon = shapely.Polygon(corners)
    assert polygon.area == pytest.approx(length * width, rel=1e-6)
    assert polygon.exterior.is_ccw
    np.testing.assert_allclose(corners.mean(axis=0), [x, y], atol=1e-9)


def test_first_corner_is_front_left() -> None:
    corners = rectangle_corners([0.0, 0.0, np.pi / 2], np.array(4.0), np.array(2.0))
    np.testing.assert_allclose(corners[0], [-1.0, 2.0], atol=1e-12)


@given(hnp.arrays(float, 3, elements=coordinates), hnp.arrays(float, 3, elements=sizes), angles)
def test_box_corners_follow_kittis_formula(
    location: np.ndarray, dimensions: np.ndarray, rotation_y: float
) -> None:
    """The development kit's: R(ry) times the corners of an upright box, plus the location."""
    height, width, length = dimensions
    turn = np.array(
        [
            [np.cos(rotation_y), 0, np.sin(rotation_y)],
            [0, 1, 0],
            [-np.sin(rotation_y), 0, np.cos(rotation_y)],
        ]
    )
    expected = {
        tuple(np.round(turn @ [sx * length / 2, -up * height, sz * width / 2] + location, 6) + 0.0)
        for sx in (-1, 1)
        for sz in (-1, 1)
        for up in (0, 1)
    }
    corners = box_corners(location, dimensions, rotation_y)
    found = {tuple(np.round(corner, 6) + 0.0) for corner in corners}
    assert max(min(np.abs(np.subtract(a, b)).max() for b in expected) for a in found) < 1e-5
    np.testing.assert_allclose(corners[:4, 1], location[1])
    np.testing.assert_allclose(corners[4:, 1], location[1] - height)
    assert np.linalg.norm(corners[0] - corners[1]) == pytest.approx(length)
    assert np.linalg.norm(corners[1] - corners[2]) == pytest.approx(width)


def test_transform_and_projection() -> None:
    shift = np.hstack([np.eye(3), [[1.0], [2.0], [3.0]]])
    np.testing.assert_allclose(transform_points(shift, np.zeros((2, 4, 3)))[1, 3], [1, 2, 3])
    camera = np.array([[700.0, 0, 600, 0], [0, 700, 180, 0], [0, 0, 1, 0]])
    pixels, depth = project(camera, [[0.0, 0.0, 10.0], [1.0, -1.0, 7.0]])
    np.testing.assert_allclose(pixels, [[600, 180], [700, 80]])
    np.testing.assert_allclose(depth, [10, 7])


@given(
    hnp.arrays(float, (2, 3), elements=st.floats(-4, 4)),
    hnp.arrays(float, (2, 2), elements=st.floats(0.5, 6)),
)
def test_iou_of_two_rectangles(poses: np.ndarray, size: np.ndarray) -> None:
    iou = bird_eye_iou(poses, size, poses, size)
    np.testing.assert_allclose(np.diag(iou), 1.0, rtol=1e-9)
    np.testing.assert_allclose(iou, iou.T, atol=1e-9)
    one, two = rectangle_polygons(poses, size[:, 0], size[:, 1])
    expected = one.intersection(two).area / one.union(two).area
    assert iou[0, 1] == pytest.approx(expected, abs=1e-7)


def test_iou_by_hand() -> None:
    iou = bird_eye_iou([[0.0, 0, 0]], [[4.0, 2]], [[2.0, 0, 0], [0, 0, np.pi / 2]], [[4.0, 2]] * 2)
    np.testing.assert_allclose(iou, [[4 / 12, 4 / 12]])


def test_pairs_far_apart_are_answered_as_shapely_does() -> None:
    rng = np.random.default_rng(0)
    poses = rng.uniform(-1, 1, (40, 3)) * (12, 12, 4)
    extent = rng.uniform(0.5, 6, (40, 2))
    polygons = rectangle_polygons(poses, extent[:, 0], extent[:, 1])
    common = shapely.area(shapely.intersection(polygons[:, None], polygons))
    area = shapely.area(polygons)
    expected = common / (area[:, None] + area - common)
    np.testing.assert_array_equal(bird_eye_iou(poses, extent, poses, extent), expected)
    assert 0.1 < (expected > 0).mean() < 0.9
    assert bird_eye_iou(np.zeros((0, 3)), np.zeros((0, 2)), poses, extent).shape == (0, 40)
