"""The range image: the rays around a direction, judged by brute force."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from avsec_gym.validation.connected.rays.range_image import (
    RangeImage,
    angles_between,
    cells_around,
    cells_between,
    range_image,
    rows_of_view,
    run_of_rays,
)
from avsec_gym.validation.connected.sweep import TIP


def _cloud(seed: int, count: int = 4000) -> np.ndarray:
    rng = np.random.default_rng(seed)
    azimuth, elevation = rng.uniform(-np.pi, np.pi, count), np.radians(rng.uniform(-30, 30, count))
    distance = rng.uniform(1.0, 60.0, count)
    return np.stack(
        [
            distance * np.cos(elevation) * np.cos(azimuth),
            distance * np.cos(elevation) * np.sin(azimuth),
            distance * np.sin(elevation) + TIP,
            np.ones(count),
        ],
        axis=1,
    ).astype(np.float32)


def _image_of(cloud: np.ndarray) -> RangeImage:
    """Of a vehicle that stands: its rays end where they did when they were sent."""
    return range_image(cloud, cloud)


def _near(image: RangeImage, azimuth: float, elevation: float, reach: float) -> set[int]:
    """The rays of the image within an angle of a direction, found by way of its cells."""
    low, high, right, left = cells_around(azimuth, elevation, reach, reach)
    directions, found = list(zip(image.azimuth, image.elevation, strict=True)), set()
    for row in range(low, high):
        for run in range(2):
            for ray in range(*run_of_rays(image, row, right, left, run)):
                if np.hypot(*angles_between(directions[ray], azimuth, elevation)) < reach:
                    found.add(ray)
    return found


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 5),
    azimuth=st.floats(-3.1415, 3.1415),
    elevation=st.floats(-0.45, 0.45),
    reach=st.floats(0.005, 0.1),
)
def test_rays_around_a_direction_are_those_that_brute_force_finds(
    seed: int, azimuth: float, elevation: float, reach: float
) -> None:
    image = _image_of(_cloud(seed))
    seen = np.asarray(image.end, float) - [0, 0, TIP]
    toward = [
        np.cos(elevation) * np.cos(azimuth),
        np.cos(elevation) * np.sin(azimuth),
        np.sin(elevation),
    ]
    angle = np.arccos(np.clip(seen @ toward / np.linalg.norm(seen, axis=1), -1, 1))
    found = _near(image, azimuth, elevation, reach)
    # Angles on a small patch of the sphere are taken for those of a plane.
    assert set(np.flatnonzero(angle < 0.93 * reach)) <= found
    assert found <= set(np.flatnonzero(angle < 1.07 * reach))


def test_every_finite_point_outside_the_vehicle_has_a_ray() -> None:
    cloud = _cloud(1, 500)
    cloud[:3, 0] = [np.nan, np.inf, -np.inf]
    cloud[3, :3] = [0.1, 0.1, TIP]
    image = _image_of(cloud)
    assert len(image.end) == 496
    order = np.lexsort(image.end.T)
    kept = cloud[4:, :3]
    assert np.array_equal(image.end[order], kept[np.lexsort(kept.T)])
    assert image.distance == pytest.approx(
        np.linalg.norm(image.end - np.float32([0, 0, TIP]), axis=1), rel=1e-5
    )


def test_an_empty_scan_has_an_image_without_a_field_of_view() -> None:
    image = _image_of(np.zeros((0, 4), np.float32))
    assert len(image.end) == 0
    assert image.lowest == image.highest


def test_angles_are_those_of_the_library_all_around() -> None:
    cloud = _cloud(3, 20000)
    # The axes, and places very near to them.
    for axis, sign in ((0, 1), (0, -1), (1, 1), (1, -1)):
        cloud[10 * axis + sign + 1, :2] = 0.0
        cloud[10 * axis + sign + 1, axis] = 7.0 * sign
    cloud[100:110, 1] *= 1e-6
    cloud[110:120, 0] *= 1e-6
    image = _image_of(cloud)
    x, y, z = (image.end.astype(float) - [0, 0, TIP]).T
    # Within a rounding of single precision, relative to the angle.
    assert image.azimuth == pytest.approx(np.arctan2(y, x), rel=1.2e-7)
    assert image.elevation == pytest.approx(np.arctan2(z, np.hypot(x, y)), rel=2e-7, abs=2e-8)


def test_rays_end_where_they_are_said_to_have_ended() -> None:
    cloud = _cloud(4, 300)
    ends = cloud + np.float32([1.0, 2.0, 3.0, 0.0])
    image, still = range_image(cloud, ends), _image_of(cloud)
    assert np.array_equal(image.end, still.end + np.float32([1.0, 2.0, 3.0]))
    assert np.array_equal(image.azimuth, still.azimuth)


@pytest.mark.parametrize(("first", "last"), [(-0.3, 0.4), (2.9, 3.5), (-3.5, -2.9), (-9.0, 9.0)])
@pytest.mark.parametrize(("lowest", "highest"), [(-2.0, 2.0), (-0.2, 0.1)])
def test_cells_between_two_directions_hold_the_rays_between_them_once(
    first: float, last: float, lowest: float, highest: float
) -> None:
    image = _image_of(_cloud(2))
    low, high, right, left = cells_between(first, last, lowest, highest)
    rays = [
        ray
        for row in range(low, high)
        for run in range(2)
        for ray in range(*run_of_rays(image, row, right, left, run))
    ]
    cell = np.radians(0.3)

    def within(margin: float) -> set[int]:
        turn = (image.azimuth.astype(float) - first + margin) % (2 * np.pi)
        up = image.elevation
        inside = (lowest - margin < up) & (up < highest + margin)
        return set(np.flatnonzero(inside & (turn < last - first + 2 * margin)))

    assert len(rays) == len(set(rays))
    assert within(0.0) <= set(rays) <= within(cell)


def test_rows_of_view_are_those_with_more_than_stray_rays() -> None:
    cloud = _cloud(2)
    rows = range(*rows_of_view(_image_of(cloud)))
    # 30 degrees up and down, in rows of 0.3 degrees of which the 150th begins at the horizon.
    assert (rows[0], rows[-1]) == (50, 249)
