"""Intervals and tests against scipy."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binomtest

from avsec_gym.metrics.intervals import mcnemar_p, wilson_interval


@given(st.integers(1, 2000).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))))
def test_wilsons_interval_is_scipys(counts: tuple[int, int]) -> None:
    successes, cases = counts
    expected = binomtest(successes, cases).proportion_ci(0.95, method="wilson")
    low, high = wilson_interval(successes, cases)
    assert low == pytest.approx(expected.low, abs=1e-12)
    assert high == pytest.approx(expected.high, abs=1e-12)
    assert 0 <= low <= successes / cases <= high <= 1


def test_no_case_no_interval() -> None:
    assert all(map(math.isnan, wilson_interval(0, 0)))


@given(st.integers(0, 300), st.integers(0, 300))
def test_mcnemar_is_the_exact_binomial_test(lost: int, gained: int) -> None:
    changed = lost + gained
    expected = binomtest(lost, changed).pvalue if changed else 1.0
    assert mcnemar_p(lost, gained) == pytest.approx(expected, rel=1e-9)
    assert mcnemar_p(lost, gained) == mcnemar_p(gained, lost)


def test_many_changes_do_not_overflow() -> None:
    assert mcnemar_p(5000, 5000) == 1.0
    assert 0 <= mcnemar_p(6000, 4000) < 1e-80
