"""The numbers of a seed: Python's and NumPy's alike."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from avsec_gym.attacks.seed_numbers import seed_numbers


@pytest.mark.parametrize(
    ("seed", "numbers"),
    [
        (7, [7]), (np.int64(7), [7]), (np.uint32(7), [7]), ((7, 0), [7, 0]),
        ([np.int64(7), 1], [7, 1]), (np.array([7, 1]), [7, 1]),
        # NumPy would make an array of floats of these.
        ([2**63, 1], [2**63, 1]),
    ],
)  # fmt: skip
def test_they_are_whole_numbers_in_a_list(seed: Any, numbers: list[int]) -> None:
    found = seed_numbers(seed)
    assert found == numbers
    assert [type(each) for each in found] == [int] * len(numbers)
