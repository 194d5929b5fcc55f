"""Crops and their mirror images."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from avsec_gym.errors import ConfigurationError
from avsec_gym.validation.connected.cropping import CropMargins, cropped, mirrored
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.vehicle_scan import VehicleScan


def _sorted(points: np.ndarray) -> np.ndarray:
    return points[np.lexsort(points.T)]


@settings(deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_crops_are_those_of_the_boxes(seed: int) -> None:
    random = np.random.default_rng(seed)
    points = random.uniform(-8, 8, (300, 4)).astype(np.float32)
    pose = np.eye(4)
    pose[:3, 3] = [100.0, -50.0, 2.0]
    scan = VehicleScan(points, pose)
    regions = Regions(
        random.uniform(-8, 8, (5, 3)) + pose[:3, 3],
        random.uniform(1, 8, (5, 3)),
        random.uniform(-4, 4, 5),
    )
    crops = cropped(scan, regions, CropMargins(0.5, 0.0, 0.2))
    grown = regions.grown(0.5, 0.2)
    world = scan.in_world()
    assert len(crops) == 5
    for index, crop in enumerate(crops):
        expected = regions.local(index, world[grown.contains(index, world)])
        assert crop == pytest.approx(expected, abs=1e-9)


def test_mirrored_twice_is_the_same_shape() -> None:
    points = np.random.default_rng(0).normal(size=(20, 3))
    once = mirrored(points)
    assert len(once) == 40
    assert np.unique(mirrored(once), axis=0) == pytest.approx(np.unique(once, axis=0))
    # Each side of the plane of symmetry is the image of the other.
    assert _sorted(once * [1, -1, 1]) == pytest.approx(_sorted(once))


def test_no_regions_and_no_points_have_no_crops() -> None:
    scan = VehicleScan(np.zeros((0, 4), np.float32), np.eye(4))
    assert cropped(scan, Regions.empty()) == []
    one = Regions(np.zeros((1, 3)), np.ones((1, 3)), np.zeros(1))
    assert [crop.shape for crop in cropped(scan, one)] == [(0, 3)]
    with pytest.raises(ConfigurationError):
        CropMargins(-1.0)
