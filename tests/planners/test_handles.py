"""`handle_of`: what is behind a handle is the arrays themselves."""

from __future__ import annotations

from typing import Any

import numba
import numpy as np

from avsec_gym.planners.handles import handle_of


@numba.njit
def doubled(handle: Any) -> Any:
    # No class of this file: what a kernel was compiled for is kept for processes without it.
    numbers, count = handle.content
    for i in range(count):
        numbers[i] *= 2.0
    return numbers.sum()


def test_what_a_kernel_writes_behind_a_handle_is_seen_by_python_and_the_other_way_round() -> None:
    numbers = np.array([1.0, 2.0, 3.0])
    handle = handle_of((numbers, 2))
    assert doubled(handle) == 2.0 + 4.0 + 3.0
    np.testing.assert_array_equal(numbers, [2.0, 4.0, 3.0])
    numbers[2] = 10.0
    assert doubled(handle) == 4.0 + 8.0 + 10.0


def test_a_handle_keeps_the_arrays_alive() -> None:
    handles = [handle_of((np.full(1000, float(i)), 0)) for i in range(100)]
    _ = [np.full(1000, -1.0) for _ in range(100)]  # Would be laid where they had been.
    assert [doubled(handle) for handle in handles] == [1000.0 * i for i in range(100)]
