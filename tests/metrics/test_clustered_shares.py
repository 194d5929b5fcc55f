"""Intervals of shares against what they promise: to hold the truth in 95 of 100 experiments."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.metrics.intervals import wilson_interval


def named(drives: int, rows: int = 1) -> list[str]:
    return [str(number) for number in range(drives) for _ in range(rows)]


def test_cases_of_their_own_drives_are_wilsons() -> None:
    told = share_of(np.arange(400) < 360, named(400))
    assert (told.count, told.of, told.rate) == (360, 400, 0.9)
    assert told.interval == pytest.approx(wilson_interval(360, 400), abs=5e-4)


def test_cases_that_are_always_alike_count_once() -> None:
    once = np.arange(100) < 80
    alike = share_of(np.repeat(once, 28).reshape(400, 7), named(100, rows=4))
    assert alike.of == 2800
    assert alike.interval == pytest.approx(share_of(once, named(100)).interval)


@pytest.mark.parametrize("hit", [True, False])
def test_where_all_cases_are_alike_the_drives_are_counted(hit: bool) -> None:
    told = share_of(np.full((200, 7), hit), named(50, rows=4))
    assert told.interval == pytest.approx(wilson_interval(50 * hit, 50))


def test_one_miss_takes_no_doubt_away() -> None:
    hits = np.ones((50, 11), bool)
    sure = share_of(hits, named(50)).interval
    hits[0, 0] = False
    low, high = share_of(hits, named(50)).interval
    assert high - low > 0.8 * (sure[1] - sure[0])


@pytest.mark.parametrize("rate", [0.5, 0.9, 0.98])
@pytest.mark.parametrize("alike", [0.05, 0.4])
def test_intervals_hold_the_truth(rate: float, alike: float) -> None:
    random = np.random.default_rng(0)
    drives = named(120, rows=2)
    strength = (1 - alike) / alike
    held = 0
    for _ in range(400):
        own = random.beta(rate * strength, (1 - rate) * strength, 120).repeat(2)
        hits = random.random((240, 3)) < own[:, None]
        low, high = share_of(hits, drives).interval
        held += low <= rate <= high
    # 400 experiments may miss 95 % by twice 1.1 %.
    assert held >= 0.915 * 400
    if alike > 0.2 and rate == 0.5:
        assert held <= 0.98 * 400


def test_a_share_of_nothing_is_none() -> None:
    assert share_of([], []) == Share(0, 0, None, None)


def test_plain_counts_have_wilsons_interval() -> None:
    assert Share.of_counts(3, 8) == Share(3, 8, 3 / 8, wilson_interval(3, 8))
    assert Share.of_counts(0, 0) == Share(0, 0, None, None)
