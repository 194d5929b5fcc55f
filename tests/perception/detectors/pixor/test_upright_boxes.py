"""From the LiDAR's view to the camera's, and back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from avsec_gym.frame import Calibration
from avsec_gym.geometry import bird_eye_iou, box_corners, project, transform_points
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.perception.detectors.pixor.upright_boxes import (
    LIDAR_HEIGHT,
    ground_heights,
    seen_from_above,
    upright_boxes,
)

RECTANGLES = np.array([[12.0, 2.0, 4.0, 1.7, 0.4], [20.0, -5.0, 4.4, 1.6, -2.8]])
SIZE = (120, 400)


def test_there_and_back(calibration: Calibration) -> None:
    boxes = upright_boxes(
        RECTANGLES, np.array([-1.7, -1.4]), np.array([0.9, 0.5]), "Car", 1.5, calibration, SIZE
    )
    back = seen_from_above(boxes, calibration)
    np.testing.assert_allclose(back, RECTANGLES, atol=1e-9)
    bottoms = transform_points(calibration.camera_to_velodyne, boxes.location)
    np.testing.assert_allclose(bottoms[:, 2], [-1.7, -1.4])
    # The front is where the heading says, also in the camera frame.
    x, y, length, _, heading = RECTANGLES[0]
    front = [x + length / 2 * np.cos(heading), y + length / 2 * np.sin(heading), -1.7]
    corners = box_corners(boxes.location, boxes.dimensions, boxes.rotation_y)[0]
    expected = transform_points(calibration.velodyne_to_camera, front)
    np.testing.assert_allclose(corners[[0, 3]].mean(axis=0), expected, atol=1e-9)
    assert boxes.alpha is not None
    bearing = np.arctan2(boxes.location[:, 0], boxes.location[:, 2])
    assert np.cos(boxes.alpha + bearing - boxes.rotation_y) == pytest.approx(1)


def test_image_boxes_are_around_the_corners(calibration: Calibration) -> None:
    boxes = upright_boxes(RECTANGLES, np.full(2, -1.7), np.ones(2), "Car", 1.5, calibration, SIZE)
    corners = box_corners(boxes.location, boxes.dimensions, boxes.rotation_y)
    pixels, _ = project(calibration.projection(2), corners[0])
    assert boxes.box2d is not None
    assert boxes.box2d[0] == pytest.approx([*pixels.min(0), *pixels.max(0)])


def test_only_what_the_image_shows(calibration: Calibration) -> None:
    beside = np.array([[3.0, 9.0, 4.0, 1.7, 0.0], [3.0, 3.0, 4.0, 1.7, 0.0]])
    arguments = (beside, np.full(2, -1.7), np.ones(2), "Car", 1.5, calibration)
    shown = upright_boxes(*arguments, SIZE)
    assert len(shown) == 1
    assert shown.box2d is not None
    assert shown.box2d[0, 0] == 0
    assert len(upright_boxes(*arguments)) == 2
    blind = Calibration(np.zeros((4, 3, 4)), np.eye(3), calibration.tr_velo_to_cam)
    without = upright_boxes(*arguments[:-1], blind)
    assert len(without) == 2
    assert without.box2d is None


def test_the_ground_is_found_under_a_hill_and_in_spite_of_stray_points() -> None:
    randomness = np.random.default_rng(0)
    points = randomness.uniform([0, -10, 0, 0], [40, 10, 0, 1], (20000, 4)).astype(np.float32)
    points[:, 2] = -1.7 + 0.03 * points[:, 0]
    points[::100, 2] -= 2.0
    ground = ground_heights(points, RECTANGLES)
    assert ground == pytest.approx(-1.7 + 0.03 * RECTANGLES[:, 0], abs=0.1)
    assert ground_heights(points[:5], RECTANGLES).tolist() == [-LIDAR_HEIGHT] * 2


def test_labels_of_a_real_frame_stand_on_the_ground_of_its_scan(shared: Path) -> None:
    data = KittiObject(shared / "kitti" / "object")
    if not (data.folder / "velodyne" / "000107.bin").is_file():
        pytest.skip("the frame is not here")
    frame, labels = data.frame("000107"), data.labels("000107")
    cars = labels[labels.category == "Car"]
    rectangles = seen_from_above(cars, frame.calibration)
    boxes = upright_boxes(
        rectangles,
        ground_heights(frame.points, rectangles),
        cars.score,
        "Car",
        1.53,
        frame.calibration,
        frame.image(2).shape[:2],
    )
    assert boxes.location == pytest.approx(cars.location, abs=0.2)
    poses, sizes = boxes.poses, np.stack([boxes.length, boxes.width], 1)
    same = bird_eye_iou(poses, sizes, cars.poses, np.stack([cars.length, cars.width], 1))
    assert np.diag(same).min() > 0.99
    assert boxes.box2d == pytest.approx(cars.box2d, abs=12)
