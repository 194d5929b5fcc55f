"""Scans as disparity maps."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import project
from avsec_gym.perception.depth.lidar import LidarDepth, visible_points
from avsec_gym.rig import kitti_rig


def frame_of(places: np.ndarray) -> SensorFrame:
    """A frame whose scan hits places in the camera frame."""
    calibration = kitti_rig().calibration
    homogeneous = np.c_[places, np.ones(len(places))]
    points = (homogeneous @ calibration.camera_to_velodyne.T).astype(np.float32)
    image = np.zeros((375, 1242, 3), np.uint8)
    return SensorFrame("000000", calibration, {2: image, 3: image}, points)


def test_points_say_the_shift_between_their_projections() -> None:
    rng = np.random.default_rng(0)
    places = rng.uniform([-4, -1, 6], [4, 1.5, 40], (200, 3))
    frame = frame_of(places)
    found = LidarDepth().disparity(frame)
    uv, depth = project(frame.calibration.projection(2), places)
    other, _ = project(frame.calibration.projection(3), places)
    pixel = np.round(uv).astype(int)
    alone = np.array([(pixel == own).all(axis=1).sum() == 1 for own in pixel])
    assert alone.sum() > 150
    values = found.values[pixel[alone, 1], pixel[alone, 0]]
    np.testing.assert_allclose(values, (uv - other)[alone, 0], rtol=1e-3)
    depths = found.depth[pixel[alone, 1], pixel[alone, 0]]
    np.testing.assert_allclose(depths, depth[alone], rtol=1e-3)
    assert found.valid.sum() == len(np.unique(pixel, axis=0))


def test_the_nearest_point_of_a_pixel_wins() -> None:
    calibration = kitti_rig().calibration
    near = np.array([1.0, 0.5, 10.0])
    # On the ray of camera 2 through it.
    centre = calibration.camera_centre(2)
    far = centre + 3 * (near - centre)
    found = LidarDepth().disparity(frame_of(np.stack([far, near, far])))
    assert found.valid.sum() == 1
    expected = calibration.focal_length(2) * calibration.baseline(2, 3) / 10.0
    assert np.nanmax(found.values) == pytest.approx(expected, rel=1e-3)


def test_points_behind_or_beside_the_image_do_not_count() -> None:
    frame = frame_of(np.array([[0.0, 0, -5.0], [50.0, 0, 5.0], [0.0, 0, 0.2], [0.0, 0, 9.0]]))
    _, depth, index = visible_points(frame.points, frame.calibration, (375, 1242), 2)
    assert index.tolist() == [3]
    assert depth[0] == pytest.approx(9.0, abs=0.01)
