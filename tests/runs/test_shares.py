"""Workers and threads, by hand and over all small clusters."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from avsec_gym.runs.shares import room, usual_threads, usual_workers

CORES = st.lists(st.integers(0, 20), min_size=1, max_size=5)


def test_one_machine_gets_what_it_always_got() -> None:
    found = {n: (usual_threads([n], None), usual_workers([n], usual_threads([n], None)))
             for n in (1, 2, 4, 6, 8, 16)}  # fmt: skip
    assert found == {1: (1, 1), 2: (1, 2), 4: (1, 4), 6: (1, 4), 8: (2, 4), 16: (4, 4)}
    assert [usual_threads([8], workers) for workers in (0, 1, 2, 3, 8, 9)] == [8, 8, 4, 2, 1, 1]


def test_a_small_driver_beside_large_machines() -> None:
    assert usual_threads([0, 16, 16], None) == 4
    assert usual_workers([0, 16, 16], 4) == 8
    # The smallest machine says how many threads, so that it has a share in the work.
    assert usual_threads([2, 16], None) == 1


@given(CORES, st.none() | st.integers(0, 40))
def test_what_is_usual_fits_where_anything_does(cores: list[int], workers: int | None) -> None:
    threads = usual_threads(cores, workers)
    assert threads >= 1
    if workers is None:
        assert usual_workers(cores, threads) <= max(1, room(cores, threads))
    elif threads > 1:
        assert room(cores, threads) >= workers
        assert room(cores, threads + 1) < max(1, workers), "there was room for more threads"
