"""Support distance error: gaps worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest

from studies.chapter5.measures.support_distance import (
    MISSED,
    support_distance_error,
    support_distances,
)

HERE = np.zeros((1, 3))
NOTHING = np.zeros((0, 5))


def rows(*rectangles: list[float]) -> np.ndarray:
    return np.array(rectangles, float).reshape(-1, 5)


def test_gaps_aside_and_along_by_hand() -> None:
    # Aside by 3 - 1, ahead by 10 - 2; across the axis: none aside; turned by 90 degrees; behind.
    found = support_distances(
        rows(
            [10, 3, 4, 2, 0], [10, 0.5, 4, 2, 0], [10, -3, 4, 2, np.pi / 2], [-10, 3, 4, 2, np.pi]
        ),
        HERE,
    )
    expected = [[2, 8], [0, 8], [1, 9], [2, 8]]
    np.testing.assert_allclose(found, [expected], atol=1e-12)


def test_gaps_are_those_of_the_car_where_it_will_be() -> None:
    # At (0, 5), facing left: what lies at x = 10 is 10 aside, what lies at y = 20 15 ahead.
    later = np.array([[0.0, 5.0, np.pi / 2]])
    found = support_distances(rows([10, 5, 2, 2, 0], [0, 20, 2, 4, 0]), later)
    np.testing.assert_allclose(found, [[[9, 0], [0, 13]]], atol=1e-12)


def test_the_larger_error_of_the_nearest_edges_counts() -> None:
    real = rows([10, 3, 4, 2, 0])
    # Aside 2 -> 2.5, along 8 -> 9.
    assert support_distance_error(real, rows([11, 3.5, 4, 2, 0]), HERE) == pytest.approx(1)
    # Too long at the far end alone: nothing.
    assert support_distance_error(real, rows([11, 3, 6, 2, 0]), HERE) == pytest.approx(0)
    assert support_distance_error(real, real, HERE) == 0


def test_missed_and_invented_objects_count_with_the_most() -> None:
    real = rows([10, 3, 4, 2, 0])
    assert support_distance_error(real, NOTHING, HERE) == MISSED
    assert support_distance_error(NOTHING, real, HERE) == MISSED
    assert support_distance_error(real, rows([10, 30, 4, 2, 0]), HERE) == MISSED
    # No box is larger an error than one that is missed.
    assert support_distance_error(rows([10, 3, 30, 9, 0]), rows([12, 3, 12, 9, 0]), HERE) == MISSED
    assert np.isnan(support_distance_error(NOTHING, NOTHING, HERE))


def test_near_objects_weigh_more() -> None:
    real = rows([10, 0, 4, 2, 0], [30, 0, 4, 2, 0])
    near_missed = support_distance_error(real, real[1:], HERE)
    far_missed = support_distance_error(real, real[:1], HERE)
    assert near_missed == pytest.approx(MISSED * (1 / 10) / (1 / 10 + 1 / 30))
    assert far_missed == pytest.approx(MISSED * (1 / 30) / (1 / 10 + 1 / 30))


def test_a_box_means_one_object_only_and_the_one_it_overlaps_most() -> None:
    # Two boxes on one object: the better one means it, the other is invented.
    real = rows([10, 3, 4, 2, 0])
    error = support_distance_error(real, rows([11, 3, 4, 2, 0], [10, 3, 4, 2, 0]), HERE)
    assert error == pytest.approx(
        MISSED * (1 / np.hypot(11, 3)) / (1 / np.hypot(11, 3) + 1 / np.hypot(10, 3))
    )


def test_errors_are_averaged_over_the_way() -> None:
    real, seen = rows([10, 3, 4, 2, 0]), rows([10, 4, 4, 2, 0])
    # Beside the object the gap along is right, the one aside wrong by 1 m; facing it, likewise.
    poses = np.array([[0.0, 0, 0], [10.0, 0, 0], [10.0, 3.5, 0]])
    # In the last, the car stands in both: gaps are 0.
    assert support_distance_error(real, seen, poses) == pytest.approx((1 + 1 + 0) / 3)
