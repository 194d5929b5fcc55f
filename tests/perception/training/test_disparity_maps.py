"""Disparity maps from the other side, and reduced."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.perception.training.disparity_maps import reduced_disparity, seen_from_right


def test_seen_from_right_moves_pixels_and_the_nearer_wins() -> None:
    left = np.zeros((1, 12), np.float32)
    left[0, 8] = 3.0  # falls on 5
    left[0, 6] = 1.0  # falls on 5 as well, farther away
    left[0, 10] = 1.5  # between 8 and 9: both
    left[0, 1] = 4.0  # falls out of the image
    expected = np.zeros((1, 12), np.float32)
    expected[0, [5, 8, 9]] = [3.0, 1.5, 1.5]
    np.testing.assert_array_equal(seen_from_right(left), expected)


def test_a_slanted_wall_has_no_holes_and_agrees_from_both_sides() -> None:
    # d(u) = 5 + u / 20 in the left image: the pixel at w in the right one sees u = (w + 5) 20 / 19.
    columns = np.arange(200, dtype=np.float32)
    left = np.tile(5 + columns / 20, (3, 1))
    right = seen_from_right(left)
    known = slice(0, 180)
    assert (right[:, known] > 0).all()
    expected = 5 + (columns + 5) * 20 / 19 / 20
    assert np.abs(right[:, known] - expected[known]).max() < 0.06


def test_reduced_plane_is_the_plane_seen_by_a_smaller_camera() -> None:
    # The road: disparity grows with the row, u' = (u + 1/2) s - 1/2.
    rows = np.arange(375, dtype=np.float32)[:, None]
    road = np.repeat(10 + 0.33 * rows, 1242, axis=1)
    small = reduced_disparity(road, 160, 640)
    centres = (np.arange(160) + 0.5) * 375 / 160 - 0.5
    expected = (10 + 0.33 * centres) * 640 / 1242
    np.testing.assert_allclose(small, np.repeat(expected[:, None], 640, axis=1), rtol=1e-5)


def test_edges_are_not_blurred_and_single_points_survive() -> None:
    edge = np.full((60, 100), 5.0, np.float32)
    edge[:, 33:] = 40.0
    small = reduced_disparity(edge, 24, 43)
    assert (np.isclose(small, 5.0 * 0.43) | np.isclose(small, 40.0 * 0.43)).all()
    sparse = np.zeros((40, 40), np.float32)
    sparse[10, 10] = 8.0
    small = reduced_disparity(sparse, 20, 20)
    assert small[5, 5] == pytest.approx(4.0)
    assert np.count_nonzero(small) == 1
    same = reduced_disparity(edge, 60, 100)
    np.testing.assert_array_equal(same, edge)
