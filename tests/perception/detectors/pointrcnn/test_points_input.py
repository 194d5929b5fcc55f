"""What the network sees of a scan."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from avsec_gym.errors import DataError
from avsec_gym.geometry import project
from avsec_gym.perception.detectors.pointrcnn.configuration import PointView
from avsec_gym.perception.detectors.pointrcnn.points_input import points_in_view, sampled_points

MakeScene = Callable[[int], Any]
VIEW = PointView((-4.0, 6.0), (0.5, 1.6), (5.0, 20.0), 100, far=15.0)


def test_only_points_in_the_region_and_the_image(scene: MakeScene) -> None:
    frame = scene(0).frame
    matrix = frame.calibration.velodyne_to_camera
    seen = {tuple(point) for point in points_in_view(frame, VIEW).round(4).tolist()}
    expected = set()
    for point in frame.points[:, :3].astype(float):
        x, y, z = matrix[:3, :3] @ point + matrix[:3, 3]
        (u, v), depth = project(frame.calibration.projection(2), np.array([x, y, z]))
        is_near = -4 <= x <= 6 and 0.5 <= y <= 1.6 and 5 <= z <= 20 and depth > 0
        if is_near and 0 <= u < 400 and 0 <= v < 120:
            expected.add(tuple(np.float32([x, y, z]).round(4).tolist()))
    assert seen == expected
    assert 100 < len(seen) < 900


def test_without_an_image_the_field_of_view_is_kittis(scene: MakeScene) -> None:
    frame = replace(scene(0).frame, images={})
    places = points_in_view(frame, PointView())
    angles = np.degrees(np.arctan2(places[:, 0], places[:, 2]))
    assert 35 < np.abs(angles).max() < 40


def test_far_points_are_all_taken_and_near_ones_by_chance() -> None:
    places = np.random.default_rng(0).uniform([-9, 0, 1], [9, 2, 19], (400, 3)).astype("f4")
    far = places[places[:, 2] >= 15]
    assert 50 < len(far) < 100
    one, two = (sampled_points(places, VIEW, np.random.default_rng(seed)) for seed in (1, 2))
    for taken in (one, two):
        assert taken.shape == (100, 3)
        assert len(np.unique(taken, axis=0)) == 100
        assert {*map(tuple, far.tolist())} <= {*map(tuple, taken.tolist())}
    assert not np.array_equal(np.sort(one, axis=0), np.sort(two, axis=0))
    np.testing.assert_array_equal(one, sampled_points(places, VIEW, np.random.default_rng(1)))


def test_at_most_a_share_is_far_unless_nothing_is_near() -> None:
    places = np.random.default_rng(0).uniform([-9, 0, 1], [9, 2, 19], (400, 3)).astype("f4")
    half = replace(VIEW, most_far=0.5)
    taken = sampled_points(places, half, np.random.default_rng(1))
    assert (taken[:, 2] >= 15).sum() == 50
    places[:380, 2] = 16.0
    taken = sampled_points(places, half, np.random.default_rng(1))
    assert taken.shape == (100, 3)
    assert (taken[:, 2] < 15).sum() == (places[:, 2] < 15).sum() > 0


def test_too_few_come_repeatedly() -> None:
    places = np.arange(21, dtype=np.float32).reshape(7, 3)
    for randomness in (np.random.default_rng(0), None):
        taken = sampled_points(places, VIEW, randomness)
        assert taken.shape == (100, 3)
        assert len(np.unique(taken, axis=0)) == 7


def test_points_that_are_added_push_out_only_as_many() -> None:
    randomness = np.random.default_rng(0)
    places = randomness.uniform([-9, 0, 1], [9, 2, 14], (900, 3)).astype("f4")
    more = randomness.uniform([-9, 0, 1], [9, 2, 14], (20, 3)).astype("f4")
    before, after, turned = (
        {*map(tuple, sampled_points(cloud, VIEW).tolist())}
        for cloud in (places, np.concatenate([more, places]), places[::-1])
    )
    assert len(before) == len(after) == 100
    assert turned == before
    pushed_in = {*map(tuple, more.tolist())}
    assert after - before <= pushed_in
    assert len(after & pushed_in) < 10


def test_chance_in_the_points_is_even_wherever_they_lie() -> None:
    """Neighbours on a grid, whose coordinates differ in a few bits, by a chi-squared test."""
    x, z = np.meshgrid(np.arange(100) * 0.01, 5 + np.arange(100) * 0.01)
    places = np.stack([x.ravel(), np.ones(x.size), z.ravel()], axis=1).astype("f4")
    taken = sampled_points(places, replace(VIEW, points=2000))
    counts, *_ = np.histogram2d(taken[:, 0], taken[:, 2], 10, [[-0.005, 0.995], [4.995, 5.995]])
    assert counts.sum() == 2000
    spread = ((counts - 20) ** 2 / 20).sum()
    # Of 99 degrees of freedom, less what drawing a fifth without putting back takes away.
    assert 45 < spread < 125


def test_nothing_in_view_is_told(scene: MakeScene) -> None:
    frame = scene(0).frame
    behind = frame.points * np.array([-1, 1, 1, 1], np.float32)
    broken = np.full((3, 4), np.nan, np.float32)
    for points in (behind, broken, behind[:0]):
        with pytest.raises(DataError, match="frame 000042 is in view"):
            points_in_view(frame.with_points(points), VIEW)
    with pytest.raises(DataError, match="no LiDAR scan"):
        points_in_view(replace(frame, scan=None), VIEW)
