"""Errors of disparity by hand."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.metrics.disparity_errors import ErrorRate, disparity_errors, error_rates, filled

NAN = float("nan")


def row(*values: float) -> np.ndarray:
    return np.array([values], np.float32)


def test_holes_get_what_is_behind() -> None:
    found = np.float32([[NAN] * 6, [NAN, 5, NAN, NAN, 2, NAN], [NAN] * 6])
    assert filled(found).tolist() == [[5, 5, 2, 2, 2, 2]] * 3
    assert filled(np.full((2, 3), np.nan, np.float32)).tolist() == [[0] * 3] * 2
    whole = np.random.default_rng(0).random((4, 5)).astype(np.float32)
    assert np.array_equal(filled(whole), whole)


def test_errors_by_hand() -> None:
    truth = row(100, 100, 100, 10, 10, NAN)
    found = row(104, 106, NAN, 13, 14, 3)
    errors = disparity_errors(found, truth)
    # 104 is off by more than 3 px, not by more than 5 %; 13 is off by 3 px, not by more.
    assert errors.found == (4, 17, 3, 2)
    # The hole becomes 13, the smaller of 106 and 13.
    assert errors.all == (5, 104, 4, 3)
    rates = error_rates([errors, errors])
    assert rates.density == ErrorRate(0.8, None)
    assert rates.found.end_point_error.value == pytest.approx(17 / 4)
    assert rates.all.off_3px.value == pytest.approx(4 / 5)
    assert rates.all.d1.value == pytest.approx(3 / 5)


def test_pixels_count_not_pairs_and_intervals_hold_the_value() -> None:
    large = disparity_errors(np.full((3, 30), 10, np.float32), np.full((3, 30), 10, np.float32))
    small = disparity_errors(row(20, 20), row(10, 10))
    d1 = error_rates([large, small], resamples=200).all.d1
    assert d1.value == pytest.approx(2 / 92, abs=1e-5)
    assert d1.interval == [0.0, 1.0]
    nothing = disparity_errors(row(1, 1), row(NAN, NAN))
    assert error_rates([nothing]).all.d1 == ErrorRate(None, None)
