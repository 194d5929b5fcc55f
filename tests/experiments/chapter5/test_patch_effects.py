"""What a ghost does is told of episodes whose ghost is seen, not of all."""

from __future__ import annotations

from types import ModuleType

import pytest

from avsec_gym.experiments.chapter5.outcomes import Condition
from avsec_gym.experiments.chapter5.patch_effects import patch_effect_rows
from avsec_gym.metrics.intervals import wilson_interval

NAMES = [f"{number:06d}" for number in range(6)]
CLEAN, RANDOM = Condition("dsgn"), Condition("dsgn", "patch-random")


def test_a_random_patch_counts_for_all_intentions_but_not_where_it_was_unsafe_anyway(
    made: ModuleType,
) -> None:
    results = made.MadeResults()
    results.add(CLEAN, NAMES, unsafe=NAMES[5:])
    results.add(RANDOM, NAMES, unsafe=[NAMES[0], NAMES[3], NAMES[5]])
    seen = dict(zip(NAMES, [1.0, 1.0, 1.0, 1.0, 0.0, 1.0], strict=True))
    results.measure(RANDOM, "ghost_seen", {**seen, NAMES[3]: 0.0})
    (row,) = patch_effect_rows(made.outcomes(results, NAMES))
    assert row.episodes == 15
    assert row.seen.value == pytest.approx(3 / 5)
    assert row.unsafe_seen.value == pytest.approx(1 / 3)
    assert row.unsafe_unseen.value == pytest.approx(1 / 2)
    low, high = row.seen.interval
    assert low < 3 / 5 < high


def test_drives_of_one_scenario_are_no_independent_cases(made: ModuleType) -> None:
    results, names = made.MadeResults(), [f"{number:06d}" for number in range(40)]
    results.add(CLEAN, names)
    results.add(RANDOM, names)
    results.measure(RANDOM, "ghost_seen", {name: float(name < names[20]) for name in names})
    (row,) = patch_effect_rows(made.outcomes(results, names))
    low, high = row.seen.interval
    # Of 40 looks, not of 120 episodes, whose interval would be 0.18 wide.
    assert high - low == pytest.approx(2 * 1.96 * (0.25 / 40) ** 0.5, rel=0.1)
    assert row.unsafe_seen.interval == pytest.approx(wilson_interval(0, 20))


def test_a_specific_patch_counts_for_its_own_intention(made: ModuleType) -> None:
    results, aimed = made.MadeResults(), Condition("dsgn", "patch-specific")
    results.add(CLEAN, NAMES)
    results.add(aimed, NAMES)
    for way, seen in (("left", 1.0), ("straight", 0.0)):
        filed = Condition("dsgn", f"patch-specific-{way}")
        results.measure(filed, "ghost_seen", dict.fromkeys(NAMES, seen))
    (row,) = patch_effect_rows(made.outcomes(results, NAMES))
    assert (row.episodes, row.seen.value, row.unsafe_seen.value) == (12, 0.5, 0.0)


def test_without_drives_unattacked_there_is_no_row(made: ModuleType) -> None:
    results = made.MadeResults()
    results.add(RANDOM, NAMES)
    results.measure(RANDOM, "ghost_seen", dict.fromkeys(NAMES, 1.0))
    assert patch_effect_rows(made.outcomes(results, NAMES)) == []


def test_where_nothing_was_measured_there_is_no_row(made: ModuleType) -> None:
    results = made.MadeResults()
    results.add(CLEAN, NAMES)
    results.add(RANDOM, NAMES)
    assert patch_effect_rows(made.outcomes(results, NAMES)) == []
