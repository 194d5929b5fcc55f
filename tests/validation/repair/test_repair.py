"""A smooth wall, attacked and repaired."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
import pytest

from avsec_gym.attacks.facula import Facula
from avsec_gym.attacks.lidar_spoofing import LidarSpoofing
from avsec_gym.attacks.sensor_combination import SensorCombination
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.sensor_system import LIDAR, SensorSystem
from avsec_gym.validation.repair.repair import REFILLED_REFLECTANCE, repair

SYSTEM = SensorSystem((LIDAR, 2, 1, 0))
SPOT = Facula(0, 180.0, (130.0, 60.0), saturation=0.5)
BOGUS = LidarSpoofing(width=1.5, distance=6.0, bearing=0.05, reference=0, rays_lost=True)


@pytest.fixture(scope="module")
def wall(wall_of: Callable[[int], SensorFrame]) -> SensorFrame:
    frame = wall_of(0)
    y, z = np.meshgrid(np.linspace(-9, 9, 240), np.linspace(-4, 4, 120))
    ahead = np.full(y.size, np.median(frame.points[:, 0]))
    points = np.stack([ahead, y.ravel(), z.ravel(), np.ones(y.size)], axis=1)
    frame = frame.with_points(points.astype(np.float32))
    for camera in (0, 1, 2):
        image = 0.5 * cv2.GaussianBlur(frame.image(camera), (0, 0), 2.0)
        frame = frame.with_image(camera, image.astype(np.uint8))
    return frame


def test_an_image_gets_back_what_the_light_hid(wall: SensorFrame) -> None:
    tampered = SPOT.attack(wall)
    repaired = repair(tampered.frame, SYSTEM, tampered.attacked)
    true, clean = tampered.pixels[0], wall.image(0).astype(float)
    error = np.abs(repaired.frame.image(0) - clean)[true].mean()
    assert error < 0.1 * np.abs(tampered.frame.image(0) - clean)[true].mean()
    untouched = ~repaired.pixels[0]
    np.testing.assert_array_equal(
        repaired.frame.image(0)[untouched], tampered.frame.image(0)[untouched]
    )
    assert repaired.frame.points is tampered.frame.points
    assert repaired.scan is None


def test_a_scan_gets_back_the_wall(wall: SensorFrame) -> None:
    tampered = BOGUS.attack(wall)
    repaired = repair(tampered.frame, SYSTEM, {LIDAR})
    assert tampered.lost is not None
    assert repaired.refilled is not None
    points = repaired.frame.points
    forward, before = points[:, 0], tampered.frame.points[:, 0]
    nearer = np.median(wall.points[:, 0]) - 1.0
    assert (before < nearer).sum() > 20 * (forward < nearer).sum()
    refilled = points[repaired.refilled]
    assert len(refilled) > 100
    assert (refilled[:, 3] == REFILLED_REFLECTANCE).all()
    # The wall is where the lost points were.
    gone = wall.points[tampered.lost]
    np.testing.assert_allclose(np.median(refilled[:, 0]), np.median(gone[:, 0]), atol=0.15)
    assert refilled[:, 1].min() > gone[:, 1].min() - 0.3
    assert refilled[:, 1].max() < gone[:, 1].max() + 0.3


def test_a_scan_is_refilled_only_where_cameras_know_how_far_away_things_are(
    wall: SensorFrame,
) -> None:
    tampered = BOGUS.attack(wall)
    away = float(np.median(wall.points[:, 0]))
    left, right = wall.calibration.projection(0), wall.calibration.projection(2)
    metres_a_pixel = away**2 / abs(left[0, 3] - right[0, 3])
    counts = [
        int(np.sum(repair(tampered.frame, SYSTEM, {LIDAR}, refill_error=error).refilled))
        for error in (0.8 * metres_a_pixel, 1.25 * metres_a_pixel)
    ]
    assert counts[0] < 0.05 * counts[1]
    with pytest.raises(ConfigurationError, match="refill_error is 0 or more metres, got -1"):
        repair(tampered.frame, SYSTEM, {LIDAR}, refill_error=-1.0)


def test_several_sensors_are_repaired_at_once_from_those_that_are_left(wall: SensorFrame) -> None:
    spot = Facula(1, 180.0, (130.0, 60.0), saturation=0.5)
    tampered = SensorCombination((spot, BOGUS)).attack(wall)
    repaired = repair(tampered.frame, SYSTEM, tampered.attacked)
    assert set(repaired.pixels) == {1}
    assert repaired.scan is not None
    assert tampered.points is not None
    assert repaired.scan.points[tampered.points].mean() > 0.9
    assert (repaired.pixels[1] & tampered.pixels[1]).sum() > 0.8 * tampered.pixels[1].sum()


def test_what_no_sensor_saw_is_reported_as_made_up(wall: SensorFrame) -> None:
    tampered = Facula(0, 200.0, (0.0, 60.0), saturation=0.5).attack(wall)
    repaired = repair(tampered.frame, SYSTEM, {0})
    # The leftmost columns of the wall are out of the other cameras' sight.
    assert repaired.made_up[0][50:70, :8].all()
    assert not repaired.made_up[0][:, 20:].any()


def test_too_few_trusted_sensors_are_said(wall: SensorFrame) -> None:
    with pytest.raises(ConfigurationError, match="trusted"):
        repair(wall, SYSTEM, {0, 1, LIDAR})
    with pytest.raises(ConfigurationError, match="no sensors of the system"):
        repair(wall, SYSTEM, {7})
