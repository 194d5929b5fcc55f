"""Physical cases: cars placed by hand, whose keypoint and visible part are plain to see."""

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.geometry import box_corners, project
from avsec_gym.perception.detectors.stereo_rcnn.keypoints import (
    checked_borders,
    decode_borders,
    decode_keypoints,
    stereo_truth,
)
from avsec_gym.perception.detectors.stereo_rcnn.stereo_camera import StereoCamera

LEFT = np.array([[700.0, 0, 600, 0], [0, 700, 170, 0], [0, 0, 1, 0]])
RIGHT = np.array([[700.0, 0, 600, -350], [0, 700, 170, 0], [0, 0, 1, 0]])
CAMERA = StereoCamera.of_projections(LEFT, RIGHT, (370, 1240))
AWAY = -np.pi / 2
REAR_LEFT, FRONT_LEFT, FRONT_RIGHT, REAR_RIGHT = range(4)


def labels(*rows, category="Car", **optional):
    """x, z, rotation_y of cars 1.5 m high, 1.6 m wide, 4 m long, on the ground 1.65 m below."""
    x, z, rotation_y = np.array(rows, float).reshape(-1, 3).T
    count = len(x)
    return Boxes3D(
        np.column_stack([x, np.full(count, 1.65), z]),
        np.tile([1.5, 1.6, 4.0], (count, 1)),
        rotation_y,
        np.ones(count),
        np.full(count, category),
        **{name: np.array(value, float) for name, value in optional.items()},
    )


@pytest.mark.parametrize(
    ("x", "rotation_y", "corner"),
    [
        (-5, AWAY, REAR_RIGHT),
        (5, AWAY, REAR_LEFT),
        (-5, -AWAY, FRONT_LEFT),
        (5, -AWAY, FRONT_RIGHT),
        (0, 0.3, FRONT_RIGHT),
        (0, -0.3, REAR_RIGHT),
    ],
)
def test_the_keypoint_is_the_corner_that_stands_out(x, rotation_y, corner):
    boxes = labels([x, 15, rotation_y])
    truth = stereo_truth(boxes, CAMERA)
    bottom = box_corners(boxes.location, boxes.dimensions, boxes.rotation_y)[0, :4]
    nearest = bottom[np.linalg.norm(bottom, axis=1).argmin()]
    known = np.isfinite(truth.keypoints[0])
    assert known.nonzero()[0].tolist() == [corner]
    assert truth.keypoints[0, corner] == pytest.approx(project(LEFT, nearest)[0][0])


def test_a_car_seen_from_right_behind_has_no_keypoint():
    assert np.isnan(stereo_truth(labels([0, 15, AWAY]), CAMERA).keypoints).all()


def test_boxes_are_the_projected_3d_boxes_of_both_views():
    boxes = labels([2, 20, 0.4], [-8, 9, AWAY])
    truth = stereo_truth(boxes, CAMERA)
    corners = box_corners(boxes.location, boxes.dimensions, boxes.rotation_y)
    for projection, view in ((LEFT, truth.left), (RIGHT, truth.right)):
        pixels, _ = project(projection, corners)
        expected = np.concatenate([pixels.min(axis=1), pixels.max(axis=1)], axis=1)
        np.testing.assert_allclose(view, np.clip(expected, 0, [1239, 369, 1239, 369]))
    np.testing.assert_allclose(truth.union[:, 0], truth.right[:, 0])
    np.testing.assert_allclose(truth.union[:, 2], truth.left[:, 2])
    np.testing.assert_allclose(truth.alpha[0], 0.4 - np.arctan2(2, 20))


def test_a_nearer_car_moves_the_border_and_hides_the_keypoint():
    free = stereo_truth(labels([-3, 25, AWAY]), CAMERA)
    assert np.isfinite(free.keypoints[0, REAR_RIGHT])
    np.testing.assert_allclose(free.borders, free.left[:, [0, 2]])
    both = stereo_truth(labels([-3, 25, AWAY], [-0.5, 12, AWAY]), CAMERA)
    assert both.borders[0, 0] == both.left[0, 0]
    assert both.borders[0, 1] == pytest.approx(both.left[1, 0], abs=1)
    assert np.isnan(both.keypoints[0]).all()
    behind = stereo_truth(labels([-3, 25, AWAY], [-3.6, 18, AWAY]), CAMERA)
    assert behind.borders[0, 0] == pytest.approx(behind.left[1, 2], abs=1)
    assert behind.borders[0, 1] == behind.left[0, 2]


def test_what_hides_need_not_be_a_car():
    van = labels([0, 10, AWAY], category="Van")
    hidden = Boxes3D.concatenate([labels([0, 30, AWAY]), van])
    walker = labels([0, 10, AWAY], category="Pedestrian")
    assert len(stereo_truth(hidden, CAMERA)) == 0
    assert len(stereo_truth(Boxes3D.concatenate([labels([0, 30, AWAY]), walker]), CAMERA)) == 1


def test_only_cars_that_can_be_seen_are_learned():
    rows = [[-4, 20, 0.3], [4, 20, 0.3], [0, -10, 0.3], [0, 200, 0.3]]
    boxes = labels(*rows, truncation=[0, 0.99, 0, 0], occlusion=[0, 0, 0, 0])
    assert len(stereo_truth(boxes, CAMERA)) == 1
    boxes = labels(*rows, truncation=[0, 0, 0, 0], occlusion=[2, 3, 0, 0])
    assert len(stereo_truth(boxes, CAMERA)) == 1
    assert len(stereo_truth(Boxes3D.empty(), CAMERA)) == 0


def test_classes_count_from_one():
    boxes = Boxes3D.concatenate(
        [labels([-4, 20, 0.3], category="Van"), labels([4, 20, 0.3]), labels([0, 40, 0])]
    )
    assert stereo_truth(boxes, CAMERA, ("Car", "Van")).classes.tolist() == [2, 1, 1]


def test_resizing_moves_whole_images():
    boxes = labels([2, 20, 0.4])
    truth = stereo_truth(boxes, CAMERA).resized(2, 3)
    change = np.array([[3, 0, 1], [0, 2, 0.5], [0, 0, 1]])
    larger = StereoCamera.of_projections(change @ LEFT, change @ RIGHT, (740, 3720))
    expected = stereo_truth(boxes, larger)
    np.testing.assert_allclose(truth.left, expected.left)
    np.testing.assert_allclose(truth.right, expected.right)
    np.testing.assert_allclose(truth.keypoints, expected.keypoints)


def test_cells_are_columns_of_the_region():
    region = np.array([[100.0, 0, 155, 40]])
    u, corner = decode_keypoints(np.array([2 * 28 + 10]), region, 28)
    assert (u[0], corner[0]) == (120.0, 2)
    np.testing.assert_array_equal(decode_borders(np.array([[0, 27]]), region, 28), [[100, 154]])


def test_borders_are_checked_against_the_other_boxes():
    boxes = np.array([[100.0, 50, 200, 120], [180, 40, 400, 200]])
    kept = checked_borders(np.array([[110.0, 170], [190, 380]]), boxes, 640)
    np.testing.assert_array_equal(kept, [[110, 170], [190, 380]])
    corrected = checked_borders(np.array([[110.0, 120], [190, 200]]), boxes, 640)
    np.testing.assert_array_equal(corrected, [[100, 179], [180, 400]])
