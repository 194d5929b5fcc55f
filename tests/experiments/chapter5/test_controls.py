"""The sanity sheet detects attacks that do not attack, and budgets that do not hold."""

from __future__ import annotations

from types import ModuleType

import pytest

from avsec_gym.experiments.chapter5.controls import (
    ControlRow,
    control_rows,
    rounding_rows,
    trend_rows,
)
from avsec_gym.experiments.chapter5.losses import precision
from avsec_gym.experiments.chapter5.outcomes import Condition
from avsec_gym.metrics.intervals import wilson_interval

CLEAN, PGD = Condition("dsgn"), Condition("dsgn", "thesis_pgd-0.4", 4.0)
PATCH, GREY = Condition("dsgn", "patch-random"), Condition("dsgn", "grey-random")
NAMES = [f"{number:06d}" for number in range(5)]


def measured(made: ModuleType, change: float = 1.6) -> list[ControlRow]:
    results = made.MadeResults()
    for condition in (CLEAN, PGD, PATCH, GREY):
        results.add(condition, NAMES)
    results.measure(CLEAN, "loss", dict.fromkeys(NAMES, 1.0))
    results.measure(PGD, "loss", dict(zip(NAMES, [3.0, 0.5, 4.0, 5.0, 6.0], strict=True)))
    results.measure(PGD, "change", {**dict.fromkeys(NAMES, 1.2), NAMES[2]: change})
    for condition, after in ((PATCH, 0.5), (GREY, 2.0)):
        results.measure(condition, "loss", dict.fromkeys(NAMES, 1.0))
        results.measure(condition, "clean_ghost_loss", dict.fromkeys(NAMES, 2.0))
        results.measure(condition, "ghost_loss", dict.fromkeys(NAMES, after))
        results.measure(condition, "change", dict.fromkeys(NAMES, 200.0))
        seen = [1.0, 1.0, 0.0, 1.0, 0.0] if after < 1 else [0.0] * 5
        results.measure(condition, "ghost_seen", dict(zip(NAMES, seen, strict=True)))
    return control_rows(made.outcomes(results, NAMES))


def test_each_attack_is_compared_with_its_own_aim(made: ModuleType) -> None:
    pgd, patch, grey = measured(made)
    assert (pgd.loss_towards, pgd.aim) == ("truth", "up")
    assert (pgd.loss_before, pgd.loss_after, pgd.share_moved.value) == (1.0, 4.0, 0.8)
    assert (patch.loss_towards, patch.aim) == ("ghosts", "down")
    assert (patch.loss_before, patch.loss_after, patch.share_moved.value) == (2.0, 0.5, 1.0)
    assert (grey.aim, grey.share_moved.value) == (None, 0.0)
    assert (pgd.ghosts_seen.value, patch.ghosts_seen.value, grey.ghosts_seen.value) == (
        None,
        0.6,
        0.0,
    )
    low, high = patch.ghosts_seen.interval
    assert low < 0.6 < high


def test_where_losses_are_not_measured_the_ghosts_are(made: ModuleType) -> None:
    results, aimed = made.MadeResults(), Condition("dsgn", "patch-specific")
    results.add(aimed, NAMES)
    for way, seen in zip(("left", "straight", "right"), (1.0, 1.0, 0.0), strict=True):
        filed = Condition("dsgn", f"patch-specific-{way}")
        results.measure(filed, "change", dict.fromkeys(NAMES, 200.0))
        results.measure(filed, "ghost_seen", dict.fromkeys(NAMES, seen))
    (row,) = control_rows(made.outcomes(results, NAMES))
    assert (row.cases, row.share_moved.value) == (0, None)
    assert row.ghosts_seen.value == pytest.approx(2 / 3)


def test_a_budget_that_is_exceeded_once_is_exceeded(made: ModuleType) -> None:
    assert measured(made)[0].within_budget is True
    pgd = measured(made, change=1.7)[0]
    assert (pgd.largest_change, pgd.budget, pgd.within_budget) == (1.7, 1.6, False)


def test_a_trend_is_the_slope_over_all_steps(made: ModuleType) -> None:
    results, names = made.MadeResults(), made.names(40)
    results.add(CLEAN, names)
    for n in range(1, 5):
        unsafe = names[: 4 * n]
        results.add(Condition("dsgn", "thesis_pgd-1", float(n)), names, lost=names, unsafe=unsafe)
    found = made.outcomes(results, names)
    (row,) = trend_rows(found)
    assert row.safety_slope.value == pytest.approx(-10)
    low, high = row.safety_slope.interval
    assert low < -10 < high < 0
    # All at once: least squares gives 2/10 of the fall for each step.
    assert row.precision_slope.value == pytest.approx(-0.2 * precision(found, CLEAN).value)


def test_rounding_is_a_paired_difference(made: ModuleType) -> None:
    results, names = made.MadeResults(), made.names(10)
    results.add(CLEAN, names)
    results.add(PGD, names, lost=names, unsafe=names[:4])
    results.add(Condition("dsgn", "thesis_pgd-0.4", 4.0, True), names, unsafe=names[:2])
    (row,) = rounding_rows(made.outcomes(results, names))
    assert row.condition == PGD
    assert row.safety_difference.value == pytest.approx(20)
    assert row.precision_difference.value == pytest.approx(row.precision_8_bit)
    assert row.precision_float == 0


def test_looks_at_one_scenario_are_a_cluster(made: ModuleType) -> None:
    """A specific patch whose ghost is seen for all intentions of a scenario, or for none."""
    results = made.MadeResults()
    results.add(Condition("dsgn", "patch-specific"), NAMES)
    for way in ("left", "straight", "right"):
        filed = Condition("dsgn", f"patch-specific-{way}")
        results.measure(filed, "change", dict.fromkeys(NAMES, 200.0))
        seen = dict(zip(NAMES, [1.0, 1.0, 0.0, 1.0, 0.0], strict=True))
        results.measure(filed, "ghost_seen", seen)
    (row,) = control_rows(made.outcomes(results, NAMES))
    assert row.ghosts_seen.interval == pytest.approx(wilson_interval(3, 5))
