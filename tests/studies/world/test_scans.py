"""Scans against boxes, edges and their own order."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.geometry import box_corners
from avsec_gym.world.rendering.lidar import Lidar
from studies.world.scans import beams, distance_outside, near_edges, statistics


def test_beams_are_told_apart_by_their_turns() -> None:
    lidar = Lidar(columns=90)
    kept = np.random.default_rng(0).random(64 * 90) > 0.2
    points = np.column_stack([lidar.directions * 10.0, np.zeros(64 * 90)]).astype(np.float32)
    expected = np.repeat(np.arange(64), 90)
    assert np.array_equal(beams(points[kept]), expected[kept])


def test_statistics_are_shares_of_the_points() -> None:
    points = np.array([[10, 0, 0, 0.0], [0, 10, 0, 0.35], [-50, 0, 0, 0.35]], np.float32)
    result = statistics(points)
    assert result.points == 3
    assert result.dark == pytest.approx(1 / 3)
    for shares in (result.range, result.elevation, result.reflectance):
        assert sum(shares) == pytest.approx(1.0)


def test_distance_outside_a_turned_box() -> None:
    box = Boxes3D(
        location=np.array([[2.0, 1.5, 20.0]]),
        dimensions=np.array([[1.4, 1.8, 4.2]]),
        rotation_y=np.array([0.7]),
        score=np.ones(1),
        category=np.array(["Car"]),
    )
    corners = box_corners(box.location, box.dimensions, box.rotation_y)[0]
    centre = corners.mean(axis=0)
    assert distance_outside(corners, box) == pytest.approx(np.zeros(8), abs=1e-9)
    assert distance_outside(centre[None], box) == pytest.approx([-0.7])
    assert (distance_outside(centre + 1.1 * (corners - centre), box) > 0.05).all()


def test_edges_are_where_disparity_jumps() -> None:
    disparity = np.full((40, 60), 10.0, np.float32)
    disparity[:, 30:] = 14.0
    disparity[:10] = np.nan
    near = near_edges(disparity)
    assert near[20:, 25:36].all()
    assert not near[20:, :20].any()
    assert near[10].all()
    assert not near[20:, 40:].any()
