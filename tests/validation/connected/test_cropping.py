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


def _standing(points: list[list[float]]) -> VehicleScan:
    return VehicleScan(np.float32([[*point, 0.5] for point in points]), np.eye(4))


@pytest.mark.parametrize("heading", [0.0, 0.7])
def test_a_crop_ends_at_its_margins(heading: float) -> None:
    # 2 m and half a metre ahead, 1 m and half a metre aside, from a quarter below to 2 m above.
    region = Regions(np.array([[5.0, -3.0, 1.0]]), np.array([[4.0, 2.0, 1.5]]), np.array([heading]))
    inside = [(2.499, 0.2, 0.5), (-2.499, 0.2, 0.5), (0.3, 1.499, 0.5), (0.3, -1.499, 0.5)]
    inside += [(2.499, -1.499, 1.999), (-2.499, 1.499, -0.249), (0.0, 0.0, 1.999)]
    beside = [(2.501, 0.2, 0.5), (-2.501, 0.2, 0.5), (0.3, 1.501, 0.5), (0.3, -1.501, 0.5)]
    beside += [(0.0, 0.0, 2.001), (0.0, 0.0, -0.251), (2.4, 1.6, 0.5), (-2.6, 1.4, 0.5)]
    turned = [complex(x, y) * np.exp(1j * heading) for x, y, _ in inside + beside]
    local = zip(turned, [z for _, _, z in inside + beside], strict=True)
    scan = _standing([[5.0 + at.real, -3.0 + at.imag, 1.0 + z] for at, z in local])
    (crop,) = cropped(scan, region, CropMargins(0.5, 0.25, 0.5))
    assert crop == pytest.approx(np.array(inside), abs=1e-5)


def test_points_on_the_very_border_belong_to_a_crop() -> None:
    region = Regions(np.zeros((1, 3)), np.array([[4.0, 2.0, 1.5]]), np.zeros(1))
    border = [[2.5, 1.5, 2.0], [-2.5, -1.5, -0.25], [2.5, 0.0, 0.0], [0.0, 1.5, 0.0]]
    (crop,) = cropped(_standing(border), region, CropMargins(0.5, 0.25, 0.5))
    assert crop.tolist() == border


def test_a_point_counts_in_every_region_in_the_scans_order() -> None:
    # More crops of points than there are points.
    regions = Regions(np.zeros((9, 3)), np.full((9, 3), 2.0), np.linspace(0.0, 0.8, 9))
    points = [[0.1, 0.2, 0.3], [-0.4, 0.5, 0.6], [9.0, 9.0, 0.0]]
    crops = cropped(_standing(points), regions)
    assert len(crops) == 9
    for index, crop in enumerate(crops):
        assert crop == pytest.approx(regions.local(index, np.array(points[:2])), abs=1e-6)


@pytest.mark.parametrize("margins", [(np.inf, 0, 0), (0, np.nan, 0), (0, 0, -0.1), (0, -0.1, 0)])
def test_margins_are_finite_and_not_negative(margins: tuple[float, float, float]) -> None:
    with pytest.raises(ConfigurationError, match="0 m or more"):
        CropMargins(*margins)
    assert CropMargins(0.0, 0.0, 0.0) != CropMargins() == CropMargins(0.0, 0.5, 0.5)
