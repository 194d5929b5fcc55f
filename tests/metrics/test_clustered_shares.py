"""Intervals of shares against what they promise: to hold the truth in 95 of 100 experiments."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.metrics.clustered_shares import (
    Share,
    difference_of_shares,
    effective_interval,
    share_of,
    share_of_trainings,
)
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


def test_trainings_that_differ_widen_the_interval() -> None:
    """By hand: the quantile of Student's t with two degrees of freedom is 4.3027."""
    hits = np.zeros((3, 100), bool)
    for row, count in zip(hits, (30, 47, 64), strict=True):
        row[:count] = True
    deviation = float(np.std([0.3, 0.47, 0.64], ddof=1)) / 3**0.5
    found = share_of_trainings(hits)
    low, high = share_of(hits.T, named(100)).interval or (0.0, 1.0)
    rate = 0.47
    assert found.rate == pytest.approx(rate)
    assert found.interval == pytest.approx(
        (
            max(0.0, rate - np.hypot(rate - low, 4.3027 * deviation)),
            min(1.0, rate + np.hypot(high - rate, 4.3027 * deviation)),
        ),
        abs=1e-4,
    )
    assert share_of_trainings(hits[:1]) == share_of(hits[:1].T, named(100))


def test_intervals_of_trainings_hold_the_truth() -> None:
    random, held = np.random.default_rng(3), 0
    for _ in range(400):
        rates = np.clip(random.normal(0.5, 0.1, 5), 0, 1)
        low, high = share_of_trainings(random.random((5, 60)) < rates[:, None]).interval
        held += low <= 0.5 <= high
    # Student's t for the trainings and Wilson's for the situations together are cautious.
    assert held >= 0.93 * 400


def test_newcombes_examples() -> None:
    """Table II of Newcombe (1998), method 10: rows (a), (c), (e) and (g)."""
    for (hits, of), (others, out_of), expected in (
        ((56, 70), (48, 80), (0.0524, 0.3339)),
        ((9, 10), (3, 10), (0.1705, 0.8090)),
        ((6, 7), (2, 7), (0.0582, 0.8062)),
        ((5, 56), (0, 29), (-0.0381, 0.1926)),
    ):
        found = difference_of_shares(Share.of_counts(hits, of), Share.of_counts(others, out_of))
        assert found.value == pytest.approx(hits / of - others / out_of)
        assert found.interval == pytest.approx(expected, abs=1e-4)
    assert difference_of_shares(Share.of_counts(1, 2), share_of([], [])).value is None


def test_weighted_cases_count_as_many_as_they_are_worth() -> None:
    assert effective_interval(0.25, 8.0) == wilson_interval(2, 8)
