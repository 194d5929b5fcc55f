"""Regions and scans of connected vehicles."""

import numpy as np
import pytest

from avsec_gym.errors import DataError
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.vehicle_scan import VehicleScan


def _one(heading: float) -> Regions:
    return Regions(np.array([[10.0, 5.0, 1.0]]), np.array([[4.0, 2.0, 1.5]]), np.array([heading]))


def test_a_region_turned_by_a_right_angle_is_long_along_y() -> None:
    points = np.array([[10.0, 6.9, 2.0], [11.9, 5.0, 2.0], [10.0, 5.0, 0.9], [10.0, 5.0, 2.6]])
    assert _one(np.pi / 2).contains(0, points).tolist() == [True, False, False, False]
    assert _one(0.0).contains(0, points).tolist() == [False, True, False, False]


def test_margins_grow_sides_and_top_and_leave_the_bottom() -> None:
    grown = _one(0.0).grown(0.5, 0.2)
    assert grown.size.tolist() == [[5.0, 3.0, 1.7]]
    assert grown.contains(0, np.array([[12.4, 6.4, 2.6], [10.0, 5.0, 0.99]])).tolist() == [
        True,
        False,
    ]


def test_a_point_ahead_of_a_region_lies_on_its_x() -> None:
    ahead = np.array([[10 + 3 * np.cos(0.4), 5 + 3 * np.sin(0.4), 1.5]])
    assert _one(0.4).local(0, ahead) == pytest.approx(np.array([[3.0, 0.0, 0.5]]))


@pytest.mark.parametrize(("size", "heading"), [(0.0, 0.0), (np.nan, 0.0), (1.0, np.inf)])
def test_regions_that_are_no_boxes_are_refused(size: float, heading: float) -> None:
    with pytest.raises(DataError):
        Regions(np.zeros((1, 3)), np.full((1, 3), size), np.array([heading]))


def test_a_scan_needs_a_rigid_pose() -> None:
    points = np.ones((3, 4), np.float32)
    pose = np.eye(4)
    pose[:3, 3] = [1.0, 2.0, 3.0]
    assert VehicleScan(points, pose).in_world()[0].tolist() == [2.0, 3.0, 4.0]
    for wrong in (2 * np.eye(4), np.full((4, 4), np.nan), np.eye(3)):
        with pytest.raises(DataError):
            VehicleScan(points, wrong)
