"""E_{i,j,k} against a plain loop, and what it must not overlook."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from avsec_gym.errors import ConfigurationError
from avsec_gym.perception.depth.depth import DisparityMap
from avsec_gym.validation.evidence.brightness import FEWEST
from avsec_gym.validation.evidence.comparison import Comparison, comparison_map
from avsec_gym.validation.evidence.disparity_error import (
    WINDOW,
    DisparityError,
    densest_share,
    disparity_error,
)

DISPARITIES = arrays.arrays(
    np.float32,
    (12, 15),
    elements=st.sampled_from([np.nan, 0.0, 1.0, 3.5, 4.0, 7.0, 60.0, 62.5, 64.0, 120.0]),
)


def by_loop(first: np.ndarray, second: np.ndarray, sparse: bool) -> tuple[int, int, int]:
    """Equation 3.2 as it is printed."""
    inconsistent = valid = pixels = 0
    for a, b in zip(first.ravel().tolist(), second.ravel().tolist(), strict=True):
        pixels += not (sparse and math.isnan(a))
        if math.isnan(a) or math.isnan(b):
            continue
        valid += 1
        difference, smaller = abs(a - b), min(a, b)
        relative = math.inf if smaller == 0 and difference > 0 else difference / (smaller or 1)
        inconsistent += difference > 3 and relative > 0.05
    return inconsistent, valid, pixels


# The kernel may have to be compiled.
@given(DISPARITIES, DISPARITIES, st.booleans())
def test_counts_are_those_of_the_equation(
    first: np.ndarray, second: np.ndarray, sparse: bool
) -> None:
    found = disparity_error(DisparityMap(first, 1.0), DisparityMap(second, 1.0), sparse=sparse)
    assert (found.inconsistent, found.valid, found.pixels) == by_loop(first, second, sparse)
    assert found.holes == found.pixels - found.valid


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1), st.floats(0, 0.3))
def test_the_densest_window_is_that_of_a_plain_search(seed: int, share: float) -> None:
    shape = 2 * WINDOW, 2 * WINDOW + 30
    random = np.random.default_rng(seed)
    wrong = random.random(shape) < share
    row, column = random.integers(0, 150, 2)
    wrong[row : row + 20, column : column + 20] = True
    found = densest_share(wrong)
    # Windows that lie in part beyond the border hold no more than others, so that whole ones do.
    sums = np.lib.stride_tricks.sliding_window_view(wrong, (WINDOW, WINDOW)).sum(axis=(2, 3))
    assert found == pytest.approx(sums.max() / WINDOW**2, abs=1e-5)


def test_the_scale_is_that_of_the_second_map() -> None:
    # 10 m against 20 m: 7 and 3.5 pixels of a pair that sees little, 28 and 14 of a wide one.
    depth = np.full((20, 20), 10.0, np.float32)
    for scale, error in ((50.0, 0.0), (70.0, 1.0), (280.0, 1.0)):
        first = DisparityMap(140.0 / depth, 140.0)
        second = DisparityMap(np.float32(scale) / (2 * depth), scale)
        assert disparity_error(first, second).error == error


def test_what_light_hides_does_not_vanish() -> None:
    """A facula makes holes: fewer pixels are compared, the others agree as before."""
    scan = np.full((40, 100), np.nan, np.float32)
    scan[::2, ::2] = 30.0
    dense = np.full_like(scan, 30.0)
    clean = disparity_error(DisparityMap(scan, 1.0), DisparityMap(dense, 1.0), sparse=True)
    assert (clean.error, clean.hole_share, clean.pixels) == (0.0, 0.0, 1000)
    dense[:, :50] = np.nan
    dazzled = disparity_error(DisparityMap(scan, 1.0), DisparityMap(dense, 1.0), sparse=True)
    assert (dazzled.error, dazzled.hole_share) == (0.0, 0.5)
    both = disparity_error(DisparityMap(dense, 1.0), DisparityMap(dense, 1.0))
    assert (both.error, both.hole_share) == (0.0, 0.5)


def test_too_little_to_compare_is_no_comfort() -> None:
    assert DisparityError(0, FEWEST, FEWEST).error == 0.0
    assert DisparityError(0, FEWEST - 1, 5000).error == 1.0
    assert DisparityError(0, 0, 0).hole_share == 1.0


def test_the_map_says_where() -> None:
    nan = np.nan
    first = DisparityMap(np.array([[nan, 5, nan, 5, 5]], np.float32), 1.0)
    second = DisparityMap(np.array([[nan, nan, 5, 6, 9]], np.float32), 1.0)
    assert comparison_map(first, second).tolist() == [list(Comparison)]


def test_maps_of_two_sizes_are_refused() -> None:
    with pytest.raises(ConfigurationError, match="one shape"):
        disparity_error(
            DisparityMap(np.zeros((2, 2), np.float32), 1.0),
            DisparityMap(np.zeros((2, 3), np.float32), 1.0),
        )
