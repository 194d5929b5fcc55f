"""The range image: the rays around a direction, judged by brute force."""

from functools import cache

import numba
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


@cache
def _crowd(seed: int) -> tuple[RangeImage, np.ndarray]:
    """An image, and the directions of its rays as unit vectors."""
    image = _image_of(_cloud(seed, 1500))
    seen = np.asarray(image.end, float) - [0, 0, TIP]
    return image, seen / np.linalg.norm(seen, axis=1, keepdims=True)


def _near(image: RangeImage, azimuth: float, elevation: float, reach: float) -> set[int]:
    """The rays of the image within an angle of a direction, found by way of its cells."""
    low, high, right, left = cells_around(azimuth, elevation, reach, reach)
    found = set()
    for row in range(low, high):
        for run in range(2):
            for ray in range(*run_of_rays(image, row, right, left, run)):
                ahead = float(image.azimuth[ray]), float(image.elevation[ray])
                if np.hypot(*angles_between(ahead, azimuth, elevation)) < reach:
                    found.add(ray)
    return found


@settings(max_examples=40, deadline=None)
@given(
    seed=st.integers(0, 2),
    azimuth=st.floats(-3.1415, 3.1415),
    elevation=st.floats(-0.45, 0.45),
    reach=st.floats(0.02, 0.1),
)
def test_rays_around_a_direction_are_those_that_brute_force_finds(
    seed: int, azimuth: float, elevation: float, reach: float
) -> None:
    image, seen = _crowd(seed)
    toward = [
        np.cos(elevation) * np.cos(azimuth),
        np.cos(elevation) * np.sin(azimuth),
        np.sin(elevation),
    ]
    angle = np.arccos(np.clip(seen @ toward, -1, 1))
    found = _near(image, azimuth, elevation, reach)
    # Angles on a small patch of the sphere are taken for those of a plane.
    assert set(np.flatnonzero(angle < 0.93 * reach)) <= found
    assert found <= set(np.flatnonzero(angle < 1.07 * reach))


def test_every_finite_point_outside_the_vehicle_has_a_ray() -> None:
    cloud = _cloud(1, 500)
    cloud[:2, 0] = [np.inf, -np.inf]
    cloud[2, :3] = [0.1, 0.1, TIP]
    image = _image_of(cloud)
    assert len(image.end) == 497
    order = np.lexsort(image.end.T)
    kept = cloud[3:, :3]
    assert np.array_equal(image.end[order], kept[np.lexsort(kept.T)])
    assert image.distance == pytest.approx(
        np.linalg.norm(image.end - np.float32([0, 0, TIP]), axis=1), rel=1e-5
    )


@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="in plain Python, NaN is in no cell")
def test_a_point_that_is_no_number_has_no_ray() -> None:
    cloud = _cloud(1, 20)
    cloud[:3] = np.where(np.eye(3, 4, dtype=bool), np.nan, cloud[:3])
    assert np.array_equal(_image_of(cloud).end, _image_of(cloud[3:]).end)


def test_an_empty_scan_has_an_image_without_a_field_of_view() -> None:
    image = _image_of(np.zeros((0, 4), np.float32))
    assert len(image.end) == 0
    assert image.lowest == image.highest


def test_angles_are_those_of_the_library_all_around() -> None:
    cloud = _cloud(3, 4000)
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
    image, _ = _crowd(2)
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


COLUMNS, ROWS, CELL = 1200, 300, np.radians(0.3)


def _points_at(cells: list[tuple[int, int]], distance: float = 9.0) -> np.ndarray:
    """Points in the middle of cells, each a row and a column."""
    row, column = np.array(cells, float).T
    azimuth, elevation = (column + 0.5) * CELL - np.pi, (row + 0.5 - 150) * CELL
    flat = distance * np.cos(elevation)
    up = distance * np.sin(elevation) + TIP
    return np.stack([flat * np.cos(azimuth), flat * np.sin(azimuth), up], 1).astype(np.float32)


def _rays_of(image: RangeImage, row: int, column: int) -> range:
    cell = row * COLUMNS + column
    return range(image.start[cell], image.start[cell + 1])


def test_each_ray_is_in_the_cell_of_its_direction_in_the_scans_order() -> None:
    cells = [(0, 0), (299, 1199), (150, 600), (7, 1199), (150, 600), (8, 0), (150, 601), (149, 600)]
    points = np.r_[_points_at(cells[:5]), np.float32([[0.1, 0.0, TIP]]), _points_at(cells[5:])]
    ends = np.arange(27, dtype=np.float32).reshape(9, 3)
    image = range_image(points, ends)
    assert image.start.shape == (ROWS * COLUMNS + 1,)
    assert (image.start[0], image.start[-1]) == (0, 8)
    own = [ends[index].tolist() for index in (0, 1, 2, 3, 4, 6, 7, 8)]
    for cell in set(cells):
        held = image.end[_rays_of(image, *cell)].tolist()
        assert held == [end for end, other in zip(own, cells, strict=True) if other == cell]
    assert image.distance == pytest.approx(np.full(8, 9.0), abs=1e-5)


def test_rays_at_the_border_of_the_image_are_in_its_last_cells() -> None:
    # Straight up and down, behind on either side of the seam, and at half a metre.
    nearest = [(0.5, 0.0, TIP), (0.5001, 0.0, TIP), (0.0, -0.4, TIP + 0.31)]
    far = [(0.0, 0.0, 5.0), (0.0, 0.0, -5.0), (-4.0, 0.0, TIP), (-4.0, -1e-3, TIP)]
    image = _image_of(np.float32([*nearest, *far]))
    assert len(image.end) == 6
    assert len(_rays_of(image, 299, 600)) == 1
    assert len(_rays_of(image, 0, 600)) == 1
    assert len(_rays_of(image, 150, 0)) == 2
    assert image.azimuth[_rays_of(image, 150, 0)] == pytest.approx([np.pi, 2.5e-4 - np.pi])


def test_small_angles_and_places_near_the_sensor_are_those_of_the_library() -> None:
    around = np.linspace(-3.1, 3.1, 41)
    points = np.stack([0.6 * np.cos(around), 0.6 * np.sin(around), 0.4 * np.cos(3 * around)], 1)
    image = _image_of(points.astype(np.float32))
    x, y, z = (image.end.astype(float) - [0, 0, TIP]).T
    assert len(image.end) == 41
    assert image.azimuth == pytest.approx(np.arctan2(y, x), rel=1e-6, abs=1e-7)
    assert image.elevation == pytest.approx(np.arctan2(z, np.hypot(x, y)), rel=1e-6, abs=1e-7)


@pytest.mark.parametrize("count", [5, 6])
def test_six_rays_in_a_row_are_a_view_and_five_are_none(count: int) -> None:
    full = [(row, column) for row in (120, 140) for column in range(10)]
    image = _image_of(_points_at(full + [(170, 20 * column) for column in range(count)]))
    last = 171 if count == 6 else 141
    assert rows_of_view(image) == (120, last)
    assert (image.lowest, image.highest) == pytest.approx((-30 * CELL, (last - 150) * CELL))


def test_the_lowest_and_the_highest_row_are_seen() -> None:
    cells = [(row, column) for row in (0, 299) for column in range(1190, 1200)]
    assert rows_of_view(_image_of(_points_at(cells))) == (0, 300)


@pytest.mark.parametrize(
    ("first", "last", "cells"),
    [
        ((150, 600), (150, 600), (150, 151, 600, 601)),
        ((10, 3), (12, 7), (10, 13, 3, 8)),
        ((-5, -4), (305, 2), (0, 300, -4, 3)),
        ((0, 0), (299, 1199), (0, 300, 0, 1200)),
        ((5, 1), (6, 1200), (5, 7, 1, 1201)),
        # More than a turn is a turn.
        ((5, 1), (6, 1201), (5, 7, 1, 1201)),
        ((5, 1), (6, 5000), (5, 7, 1, 1201)),
    ],
)
def test_cells_between_the_middles_of_two_cells(
    first: tuple[int, int], last: tuple[int, int], cells: tuple[int, int, int, int]
) -> None:
    lowest, highest = ((row + 0.5 - 150) * CELL for row in (first[0], last[0]))
    right, left = ((column + 0.5) * CELL - np.pi for column in (first[1], last[1]))
    assert cells_between(right, left, lowest, highest) == cells


@pytest.mark.parametrize(
    ("elevation", "across", "side"),
    [
        (0.0, 0.033, 0.033),
        (np.pi / 3, 0.033, 0.066),
        (-np.pi / 3, 0.033, 0.066),
        # At most as of a direction whose cosine is a tenth, and a quarter of a turn.
        (1.5, 0.033, 0.33),
        (1.5, 0.4, np.pi / 2),
    ],
)
def test_cells_around_a_direction_are_more_the_higher_it_is(
    elevation: float, across: float, side: float
) -> None:
    expected = cells_between(0.7 - side, 0.7 + side, elevation - 0.02, elevation + 0.02)
    assert cells_around(0.7, elevation, across, 0.02) == expected


def test_a_run_ends_at_the_seam_and_the_other_begins_there() -> None:
    # One ray in each cell: rays have the numbers of their cells.
    image = _image_of(np.zeros((0, 3), np.float32))
    image = image._replace(start=np.arange(ROWS * COLUMNS + 1, dtype=np.int32))
    row = 4 * COLUMNS
    for columns, one, other in (
        ((5, 9), (5, 9), (0, 0)),
        ((1195, 1204), (1195, 1200), (0, 4)),
        ((1195, 1200), (1195, 1200), (0, 0)),
        ((-3, 2), (1197, 1200), (0, 2)),
        ((-8, -3), (1192, 1197), (0, 0)),
        ((600, 1800), (600, 1200), (0, 600)),
        ((2405, 2409), (5, 9), (0, 0)),
    ):
        runs = [run_of_rays(image, 4, *columns, run) for run in range(2)]
        assert [(a - row, b - row) for a, b in runs] == [one, other]


@pytest.mark.parametrize(
    ("ray", "direction", "angles"),
    [
        ((0.5, 0.2), (0.4, 0.0), (0.1, 0.2)),
        ((0.5, 0.2), (0.4, np.pi / 3), (0.05, 0.2 - np.pi / 3)),
        ((-0.3, -0.2), (0.4, -np.pi / 3), (-0.35, np.pi / 3 - 0.2)),
        # Across the seam, either way; and by half a turn less a little.
        ((3.1, 0.0), (-3.1, 0.0), (6.2 - 2 * np.pi, 0.0)),
        ((-3.1, 0.0), (3.1, 0.1), ((2 * np.pi - 6.2) * np.cos(0.1), -0.1)),
        ((3.0, 0.0), (0.0, 0.0), (3.0, 0.0)),
        ((3.0, 0.0), (-0.3, 0.0), (3.3 - 2 * np.pi, 0.0)),
    ],
)
def test_angles_between_directions(
    ray: tuple[float, float], direction: tuple[float, float], angles: tuple[float, float]
) -> None:
    assert angles_between(ray, *direction) == pytest.approx(angles, abs=1e-9)
