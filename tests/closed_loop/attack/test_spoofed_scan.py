"""The bogus plane stays at its place in the world while the car drives on."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.closed_loop.attack.spoofed_scan import SpoofedScan
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import transform_points
from avsec_gym.rig import kitti_rig
from tests.closed_loop.attack.surroundings import around

LAID = np.array([1.0, 0.0, 0.125, 1.0, 1.0])
"""22.5 m ahead, 1 m to the left, as large as can be."""


def bogus_points(attack: SpoofedScan, pose: tuple[float, float, float]) -> np.ndarray:
    """In the world frame, shape (N, 2)."""
    calibration = kitti_rig().calibration
    empty = SensorFrame("000000", calibration, {}, np.zeros((0, 4), np.float32))
    points = attack.tampered(empty, around(pose)).points[:, :3]
    camera = transform_points(calibration.velodyne_to_camera, points)
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    x, y = camera[:, 2], -camera[:, 0]
    return np.column_stack([pose[0] + cos * x - sin * y, pose[1] + sin * x + cos * y])


def test_the_plane_stays_where_it_was_laid() -> None:
    attack = SpoofedScan()
    assert attack.act(LAID, around((0.0, 0.0, 0.0))) == pytest.approx(1.0)
    for pose in ((0.0, 0.0, 0.0), (8.0, 0.5, 0.1), (15.0, -1.0, -0.2)):
        attack.act(LAID, around(pose))
        points = bogus_points(attack, pose)
        assert len(points) > 30
        np.testing.assert_allclose(points.mean(axis=0), [22.5, 1.0], atol=0.15)
    # The car has driven through it, and it is taken down.
    assert len(bogus_points(attack, (22.0, 1.0, 0.0))) == 0
    assert attack.act(-LAID, around((0.0, 0.0, 0.0))) == 0.0
    assert len(bogus_points(attack, (0.0, 0.0, 0.0))) == 0
