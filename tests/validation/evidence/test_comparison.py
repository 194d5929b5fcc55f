"""Two disparity maps, pixel by pixel, by hand."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.perception.depth.depth import DisparityMap
from avsec_gym.validation.evidence.comparison import Comparison, comparison_map

_NONE = float("nan")
_PAIRS = [
    (_NONE, _NONE, Comparison.UNKNOWN),
    (5.0, _NONE, Comparison.FIRST_ONLY),
    (_NONE, 5.0, Comparison.SECOND_ONLY),
    (10.0, 10.0, Comparison.CONSISTENT),
    # Up to 60 pixels, more than 3 pixels are inconsistent.
    (10.0, 13.0, Comparison.CONSISTENT),
    (13.0, 10.0, Comparison.CONSISTENT),
    (10.0, 13.125, Comparison.INCONSISTENT),
    (13.125, 10.0, Comparison.INCONSISTENT),
    (0.0, 3.5, Comparison.INCONSISTENT),
    (0.0, 2.5, Comparison.CONSISTENT),
    (59.0, 62.125, Comparison.INCONSISTENT),
    # Above, more than a twentieth of the smaller one.
    (64.0, 67.125, Comparison.CONSISTENT),
    (100.0, 104.75, Comparison.CONSISTENT),
    (104.75, 100.0, Comparison.CONSISTENT),
    (100.0, 105.125, Comparison.INCONSISTENT),
    (105.125, 100.0, Comparison.INCONSISTENT),
    (200.0, 209.5, Comparison.CONSISTENT),
    (200.0, 210.25, Comparison.INCONSISTENT),
]


@pytest.mark.parametrize("shape", [(3, 6), (6, 3), (18, 1), (1, 18)])
def test_every_pixel_is_compared(shape: tuple[int, int]) -> None:
    first, second, expected = (
        np.array(column).reshape(shape) for column in zip(*_PAIRS, strict=True)
    )
    found = comparison_map(
        DisparityMap(first.astype(np.float32), 100.0),
        DisparityMap(second.astype(np.float32), 100.0),
    )
    assert found.dtype == np.uint8
    assert found.tolist() == expected.tolist()


def test_the_scale_is_that_of_the_second_map() -> None:
    # Half the baseline, half the disparity: 4 pixels apart there are 8 here, and 2 are 4.
    first = DisparityMap(np.float32([[10.0, 10.0, 20.0]]), 50.0)
    second = DisparityMap(np.float32([[20.0, 22.0, 44.0]]), 100.0)
    assert comparison_map(first, second).tolist() == [[3, 3, 4]]
    assert comparison_map(second, first).tolist() == [[3, 3, 3]]


def test_what_is_known_of_a_pixel_is_counted_from_nothing_to_a_contradiction() -> None:
    names = ["UNKNOWN", "FIRST_ONLY", "SECOND_ONLY", "CONSISTENT", "INCONSISTENT"]
    assert [Comparison[name] for name in names] == [0, 1, 2, 3, 4]


@pytest.mark.parametrize("shape", [(2, 3), (1, 2), (2, 1)])
def test_maps_of_two_shapes_are_refused(shape: tuple[int, int]) -> None:
    square = DisparityMap(np.zeros((2, 2), np.float32), 1.0)
    with pytest.raises(ConfigurationError, match="one shape"):
        comparison_map(square, DisparityMap(np.zeros(shape, np.float32), 1.0))
