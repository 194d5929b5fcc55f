"""The grid against plain loops over points."""

from __future__ import annotations

import math

import numpy as np

from avsec_gym.frame import Points
from avsec_gym.geometry import Floats
from avsec_gym.perception.detectors.pixor.bird_eye_input import bird_eye_input
from avsec_gym.perception.detectors.pixor.configuration import BirdEyeRegion

REGION = BirdEyeRegion((0.0, 4.0), (-2.0, 3.0), (-2.5, 1.0), 0.5, 0.25)


def by_loops(points: Points, region: BirdEyeRegion) -> Floats:
    grid = np.zeros((15, 10, 8))
    seen: dict[tuple[int, int], list[float]] = {}
    for x, y, z, reflectance in points.tolist():
        if 0 < x < 4 and -2 < y < 3 and -2.5 < z < 1:
            row, column = math.floor((y + 2) / 0.5), math.floor(x / 0.5)
            grid[math.floor((z + 2.5) / 0.25), row, column] = 1
            seen.setdefault((row, column), []).append(reflectance)
    for (row, column), values in seen.items():
        grid[14, row, column] = sum(values) / len(values)
    return grid


def test_as_by_loops() -> None:
    randomness = np.random.default_rng(0)
    points = randomness.uniform([-1, -3, -3, 0], [5, 4, 2, 1], (500, 4)).astype(np.float32)
    found = bird_eye_input(points, REGION)
    assert found.dtype == np.float32
    assert found.shape == REGION.shape == (15, 10, 8)
    np.testing.assert_allclose(found, by_loops(points, REGION), atol=1e-6)
    assert 0.1 < found[:-1].mean() < 0.9


def test_borders_are_outside_and_just_within_them_is_inside() -> None:
    for axis, (low, high) in enumerate((REGION.forward, REGION.left, REGION.up)):
        for border, other in ((low, high), (high, low)):
            point = np.array([[1.1, 0.1, 0.1, 0.5]], np.float32)
            point[0, axis] = border
            assert not bird_eye_input(point, REGION).any()
            point[0, axis] = np.nextafter(np.float32(border), np.float32(other))
            assert bird_eye_input(point, REGION).sum() == 1.5


def test_broken_points_and_none_at_all() -> None:
    points = np.array([[np.nan, 0, 0, 1], [1, np.inf, 0, 1]], np.float32)
    assert not bird_eye_input(points, REGION).any()
    assert not bird_eye_input(points[:0], REGION).any()
