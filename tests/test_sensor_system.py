"""The order of sensors."""

from __future__ import annotations

import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.rig import kitti_rig
from avsec_gym.sensor_system import KITTI_SYSTEM, SensorSystem


def test_kitti_stands_from_right_to_left() -> None:
    KITTI_SYSTEM.check(kitti_rig().calibration)
    assert KITTI_SYSTEM.reference == 2
    assert KITTI_SYSTEM.triples == ((0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3))


@pytest.mark.parametrize(
    "sensors",
    [("lidar", 2), ("lidar", 2, 2), (3, "lidar", 2), (3, 2, -1), (True, 2, 3), (1, "x", 2)],
)
def test_what_is_no_system(sensors: tuple[int | str, ...]) -> None:
    with pytest.raises(ConfigurationError):
        SensorSystem(sensors)


def test_cameras_in_another_order_are_refused() -> None:
    with pytest.raises(ConfigurationError, match=r"camera 3 is 0\.53 m right of camera 2"):
        SensorSystem(("lidar", 2, 3)).check(kitti_rig().calibration)
