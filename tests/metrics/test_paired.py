"""Paired differences and their bootstrap."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import binomtest

from avsec_gym.metrics.estimate import NOTHING, Estimate
from avsec_gym.metrics.paired import holm_p, paired_differences, scenario_p
from avsec_gym.metrics.safety import COLLISION, SAFE, UNPLANNED, SafetyRates, SafetyRecord


def records(outcomes: list[str]) -> list[SafetyRecord]:
    return [
        SafetyRecord(f"{i:06d}", "left", outcome, math.nan, 0, math.nan, math.nan)
        for i, outcome in enumerate(outcomes)
    ]


def random_outcomes(rng: np.random.Generator, count: int, shares: tuple[float, ...]) -> list[str]:
    return rng.choice([SAFE, COLLISION, UNPLANNED], count, p=shares).tolist()


def test_differences_are_those_of_the_rates() -> None:
    rng = np.random.default_rng(0)
    first = records(random_outcomes(rng, 200, (0.8, 0.1, 0.1)))
    second = records(random_outcomes(rng, 200, (0.6, 0.2, 0.2)))
    found = paired_differences(first, second)
    one, two = SafetyRates.of(first), SafetyRates.of(second)
    for name in ("success_rate", "collision_rate", "safe_driving_rate"):
        estimate = getattr(found, name)
        assert estimate.value == pytest.approx(getattr(two, name) - getattr(one, name), abs=1e-12)
        low, high = estimate.interval
        assert low < estimate.value < high
    lost = sum(a.safe and not b.safe for a, b in zip(first, second, strict=True))
    gained = sum(b.safe and not a.safe for a, b in zip(first, second, strict=True))
    assert (found.became_unsafe, found.became_safe) == (lost, gained)
    assert found.mcnemar_p == pytest.approx(binomtest(lost, lost + gained).pvalue)


def test_pairing_narrows_the_interval() -> None:
    """190 of 200 pairs agree: the difference is far surer than that of two independent samples."""
    first = [SAFE] * 100 + [UNPLANNED] * 100
    second = [SAFE] * 90 + [UNPLANNED] * 110
    found = paired_differences(records(first), records(second))
    assert found is not None
    assert found.safe_driving_rate.interval is not None
    low, high = found.safe_driving_rate.interval
    spread = math.sqrt(0.05 * 0.95 / 200)
    assert low == pytest.approx(-0.05 - 1.96 * spread, abs=0.012)
    assert high == pytest.approx(-0.05 + 1.96 * spread, abs=0.012)


def test_intervals_cover_the_true_difference() -> None:
    rng, covered = np.random.default_rng(1), 0
    for trial in range(200):
        first = random_outcomes(rng, 120, (0.8, 0.1, 0.1))
        turns = rng.random(120) < 0.1
        second = [UNPLANNED if turn else word for word, turn in zip(first, turns, strict=True)]
        found = paired_differences(records(first), records(second), resamples=1000, seed=trial)
        assert found is not None
        assert found.safe_driving_rate.interval is not None
        low, high = found.safe_driving_rate.interval
        covered += low <= -0.08 <= high
    assert 0.88 <= covered / 200 <= 0.99


def test_the_seed_decides() -> None:
    rng = np.random.default_rng(2)
    pair = [records(random_outcomes(rng, 50, (0.6, 0.2, 0.2))) for _ in range(2)]
    assert paired_differences(*pair, seed=3) == paired_differences(*pair, seed=3)
    assert paired_differences(*pair, seed=3) != paired_differences(*pair, seed=4)


def test_equal_inputs_differ_by_nothing() -> None:
    one = records([SAFE, COLLISION, UNPLANNED] * 10)
    found = paired_differences(one, one)
    assert found is not None
    assert found.safe_driving_rate == Estimate(0.0, [0.0, 0.0])
    assert found.mcnemar_p == 1.0


def test_without_plans_there_is_no_collision_rate() -> None:
    found = paired_differences(records([UNPLANNED] * 5), records([UNPLANNED] * 4 + [SAFE]))
    assert found is not None
    assert found.collision_rate == NOTHING
    assert found.success_rate.value == pytest.approx(0.2)


def test_nothing_and_what_does_not_match() -> None:
    assert paired_differences([], []) is None
    with pytest.raises(ValueError, match="same scenarios"):
        paired_differences(records([SAFE]), records([SAFE, SAFE]))
    with pytest.raises(ValueError, match="same scenarios"):
        paired_differences(records([SAFE, SAFE]), records([SAFE, SAFE])[::-1])


def test_records_of_one_scenario_are_drawn_together() -> None:
    """Three equal records a scenario are no more evidence than one."""
    rng = np.random.default_rng(5)
    first, second = (random_outcomes(rng, 150, (0.7, 0.2, 0.1)) for _ in range(2))
    once = paired_differences(records(first), records(second))
    thrice = paired_differences(records(first) * 3, records(second) * 3)
    assert once is not None
    assert thrice is not None
    assert thrice.scenarios == once.scenarios
    assert thrice.episodes == 3 * once.episodes
    assert thrice.mcnemar_p is None
    for name in ("success_rate", "collision_rate", "safe_driving_rate"):
        one, three = getattr(once, name), getattr(thrice, name)
        assert three.value == pytest.approx(one.value)
        assert three.interval == pytest.approx(one.interval)


def test_json_has_the_interval_beside_the_rate() -> None:
    found = paired_differences(records([SAFE] * 4), records([SAFE, SAFE, COLLISION, UNPLANNED]))
    assert found is not None
    row = found.to_json()
    assert (row["scenarios"], row["became_unsafe"], row["mcnemar_p"]) == (4, 2, 0.5)
    assert row["collision_rate"] == pytest.approx(1 / 3)
    assert row["collision_rate_interval"] == found.collision_rate.interval


def test_p_values_are_corrected_for_all_rows_that_have_one() -> None:
    safe, turned = records([SAFE] * 8), records([COLLISION] * 8)
    pair = paired_differences(safe, turned)
    thrice = paired_differences(safe * 3, turned * 3)
    # McNemar's p is 2 / 2^8, and three of four rows have one.
    assert holm_p([pair, None, pair, thrice, pair]) == pytest.approx(
        [6 / 256, None, 6 / 256, None, 6 / 256]
    )


def test_drives_are_drawn_whole() -> None:
    """Ten drives of twelve alike scenarios each are as sure of a difference as ten scenarios."""
    first, second = [SAFE] * 10, [SAFE] * 6 + [UNPLANNED] * 4
    each = paired_differences(records(first), records(second))
    repeated = [records(np.repeat(outcomes, 12).tolist()) for outcomes in (first, second)]
    by_drive = paired_differences(*repeated, cluster=lambda one: str(int(one.scenario) // 12))
    by_scenario = paired_differences(*repeated)
    assert each is not None
    assert by_drive is not None
    assert by_scenario is not None
    assert by_drive.safe_driving_rate.interval == pytest.approx(each.safe_driving_rate.interval)
    assert (by_drive.scenarios, by_drive.mcnemar_p) == (120, None)
    narrow, wide = (np.diff(found.safe_driving_rate.interval) for found in (by_scenario, by_drive))
    assert wide > 2.5 * narrow
    alone = paired_differences(*repeated, cluster=lambda one: "")
    assert alone is not None
    assert alone.safe_driving_rate == Estimate(pytest.approx(-0.4), None)


def test_scenarios_are_counted_by_what_their_episodes_gain_together() -> None:
    """Of eight scenarios with three episodes seven gain, of which one also loses, and one loses."""
    before = [UNPLANNED, UNPLANNED, SAFE] * 7 + [SAFE, UNPLANNED, SAFE]
    after = [SAFE, SAFE, SAFE] * 6 + [SAFE, SAFE, UNPLANNED] + [UNPLANNED, UNPLANNED, SAFE]
    one, other = (
        [replace(each, scenario=str(n // 3)) for n, each in enumerate(records(outcomes))]
        for outcomes in (before, after)
    )
    assert scenario_p(one, other) == pytest.approx(binomtest(1, 8).pvalue)
    assert scenario_p(other, one) == scenario_p(one, other)
