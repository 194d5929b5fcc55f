"""What stands up in a scan is an obstacle; roads, slopes and what hangs above are none."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.perception.detectors.pixor.upright_boxes import seen_from_above
from avsec_gym.perception.detectors.scan_obstacles import ScanObstacles
from avsec_gym.rig import kitti_rig

CALIBRATION = kitti_rig().calibration
GROUND = -1.73


def road(slope: float = 0.0) -> np.ndarray:
    x, y = np.meshgrid(np.arange(3.0, 45.0, 0.1), np.arange(-9.0, 9.0, 0.1))
    return np.stack([x, y, GROUND + slope * x], axis=-1).reshape(-1, 3)


def wall(x: float, y: float, width: float, low: float, high: float, yaw: float = 0.0) -> np.ndarray:
    across, z = np.meshgrid(np.arange(0.0, width, 0.05) - width / 2, np.arange(low, high, 0.1))
    places = [x - across * np.sin(yaw), y + across * np.cos(yaw), GROUND + z]
    return np.stack(places, axis=-1).reshape(-1, 3)


def found(*surfaces: np.ndarray, **settings: Any) -> np.ndarray:
    """Rectangles x, y, length, width, heading in the velodyne frame, nearest first."""
    points = np.concatenate(surfaces)
    scan = np.c_[points, np.full(len(points), 0.3)].astype(np.float32)
    boxes = ScanObstacles(**settings).detect(SensorFrame("000000", CALIBRATION, scan=scan))
    assert set(boxes.category) <= {"Misc"}
    assert ((boxes.score > 0.3) & (boxes.score < 1)).all()
    rectangles = seen_from_above(boxes, CALIBRATION)
    return rectangles[np.argsort(rectangles[:, 0])]


@pytest.mark.parametrize("slope", [0.0, 0.1, -0.1])
def test_a_road_is_no_obstacle_also_on_a_slope(slope: float) -> None:
    assert not len(found(road(slope)))


def test_walls_are_found_where_they_are_as_wide_as_they_are() -> None:
    rectangles = found(road(), wall(10, 2, 1.8, 0, 1.5), wall(20, -3, 1.0, 0, 0.8))
    np.testing.assert_allclose(rectangles[:, :2], [[10, 2], [20, -3]], atol=0.1)
    np.testing.assert_allclose(rectangles[:, 2], [1.75, 0.95], atol=0.1)
    assert (rectangles[:, 3] < 0.3).all()


def test_a_wall_that_is_turned_has_its_heading() -> None:
    [[*_, heading]] = found(road(), wall(12, 0, 3.0, 0, 1.5, yaw=0.5))
    assert np.sin(2 * (heading - np.pi / 2 - 0.5)) == pytest.approx(0, abs=0.05)


def test_kerbs_and_what_hangs_above_are_driven_over_and_under() -> None:
    assert not len(found(road(), wall(10, 0, 3, 0, 0.2), wall(15, 0, 6, 2.1, 5.0)))
    assert len(found(road(), wall(15, 0, 6, 2.1, 5.0), headroom=4.0))


def test_a_long_hedge_around_a_bend_is_no_box_across_the_road() -> None:
    hedges = [wall(x, 8.0, 0.4, 0, 1.5) for x in np.arange(5.0, 40.0, 0.3)]
    hedges += [wall(40.0, y, 0.4, 0, 1.5) for y in np.arange(-8.0, 8.0, 0.3)]
    rectangles = found(road(), *hedges)
    assert len(rectangles) > 8
    assert (rectangles[:, 2] < 6).all()
    reach = np.hypot(rectangles[:, 2], rectangles[:, 3]) / 2
    in_lane = (np.abs(rectangles[:, 1]) - reach < 1.75) & (rectangles[:, 0] + reach < 38)
    assert not in_lane.any()


def test_few_points_are_none() -> None:
    assert not len(found(road(), wall(10, 0, 0.1, 0, 0.5), fewest=30))


def test_a_frame_without_scan_and_numbers_that_cannot_be_are_refused() -> None:
    with pytest.raises(DataError, match="scan"):
        ScanObstacles().detect(SensorFrame("000000", CALIBRATION))
    empty = SensorFrame("000000", CALIBRATION, scan=np.zeros((0, 4), np.float32))
    assert not len(ScanObstacles().detect(empty))
    with pytest.raises(ConfigurationError, match="step takes a number"):
        ScanObstacles(step=0.0)
