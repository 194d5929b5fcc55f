"""What is wrong with a scan of a wall 8 m ahead, as three cameras see it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.attacks.lidar_spoofing import LidarSpoofing
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.sensor_system import LIDAR
from avsec_gym.validation.repair.damaged_scan import damaged_scan, trusted_maps

CAMERAS = (0, 1, 2)
BOGUS = LidarSpoofing(width=1.5, distance=6.0, bearing=0.05, reference=0)


@pytest.fixture(scope="module")
def wall(wall_of: Callable[[int], SensorFrame]) -> SensorFrame:
    """With a scan that reaches farther than the cameras see."""
    frame = wall_of(0)
    y, z = np.meshgrid(np.linspace(-9, 9, 240), np.linspace(-4, 4, 120))
    ahead = np.full(y.size, np.median(frame.points[:, 0]))
    points = np.stack([ahead, y.ravel(), z.ravel(), np.ones(y.size)], axis=1)
    return frame.with_points(points.astype(np.float32))


def test_a_sound_scan_is_sound(wall: SensorFrame) -> None:
    found = damaged_scan(wall, CAMERAS)
    assert not found.points.any()
    assert not found.lost.any()


@pytest.mark.parametrize("rays_lost", [False, True])
def test_bogus_points_are_found_and_what_they_hide(wall: SensorFrame, rays_lost: bool) -> None:
    tampered = replace(BOGUS, rays_lost=rays_lost).attack(wall)
    found, true = damaged_scan(tampered.frame, CAMERAS), tampered.points
    assert true is not None
    assert (found.points & true).sum() > 0.95 * (found.points | true).sum()
    if tampered.lost is None:
        assert not found.lost.any(), "all returns are still there"
    else:
        seen = found.is_lost(wall.points)
        assert (seen & tampered.lost).sum() > 0.8 * (seen | tampered.lost).sum()


def test_points_behind_what_cameras_see_are_bogus_too(wall: SensorFrame) -> None:
    points = wall.points.copy()
    moved = np.abs(points[:, 1]) < 1.0
    points[moved, :3] *= 1.5
    found = damaged_scan(wall.with_points(points), CAMERAS)
    in_sight = np.abs(points[:, 2] / points[:, 0]) < 0.2
    assert found.points[moved & in_sight].mean() > 0.9
    assert not found.points[~moved & (np.abs(wall.points[:, 1]) > 1.3)].any()


def test_nothing_is_said_of_what_no_camera_sees(wall: SensorFrame) -> None:
    behind = wall.points * np.array([-1, 1, 1, 1], np.float32)
    frame = wall.with_points(np.concatenate([wall.points, behind]))
    assert not damaged_scan(frame, CAMERAS).points.any()


def test_pairs_are_wide_and_apart(wall: SensorFrame) -> None:
    assert list(trusted_maps(wall, (LIDAR, *CAMERAS))) == [0]
    with pytest.raises(ConfigurationError, match="two trusted cameras"):
        damaged_scan(wall, (2,))
