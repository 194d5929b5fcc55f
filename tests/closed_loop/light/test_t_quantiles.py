"""Quantiles of Student's t from the table, held against scipy's."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ndtr, stdtrit

from avsec_gym.closed_loop.light.t_quantiles import FARTHEST, quantile_table, t_quantile


@pytest.mark.parametrize("freedom", [0.7, 1.0, 2.5, 4.0, 30.0, 1e4])
def test_the_table_is_as_good_as_the_function(freedom: float) -> None:
    table = quantile_table((3.0, freedom))
    # Of scipy's own, the upper half is less exact: shares near 1 have few digits.
    drawn = np.random.default_rng(0).standard_normal(2000)
    normal = np.concatenate([-np.abs(drawn), [-6.0, -4.5, -1e-9]])
    expected = stdtrit(freedom, ndtr(normal))
    found = np.array([t_quantile(table, 1, each) for each in normal])
    assert found == pytest.approx(expected, rel=1e-7, abs=1e-7)
    mirrored = np.array([t_quantile(table, 1, -each) for each in normal])
    assert mirrored == pytest.approx(-found, rel=1e-9)
    assert t_quantile(table, 0, -1.0) == pytest.approx(stdtrit(3.0, ndtr(-1.0)), rel=1e-8)


def test_it_rises_and_ends_where_no_number_is_drawn() -> None:
    table = quantile_table((2.0,))
    values = [t_quantile(table, 0, each) for each in np.linspace(-9, 9, 4001)]
    assert (np.diff(values) >= 0).all()
    assert values[0] == t_quantile(table, 0, -FARTHEST)
    assert t_quantile(table, 0, 0.0) == pytest.approx(0.0, abs=1e-12)
