"""What is found, and where ghosts stand, is counted scenario by scenario."""

from __future__ import annotations

from types import ModuleType

import pytest

from avsec_gym.experiments.chapter5.outcomes import Condition
from avsec_gym.experiments.chapter5.seen import found_cars, seen_rows

CLEAN, WEAK = Condition("dsgn"), Condition("dsgn", "thesis_pgd-1", 2.0)
STRONG, AIMED = Condition("dsgn", "thesis_pgd-1", 4.0), Condition("dsgn", "patch-specific")
NAMES = [f"{number:06d}" for number in range(4)]


def test_ghosts_in_the_lanes_and_beside_them(made: ModuleType) -> None:
    results = made.MadeResults()
    beside = made.boxes(made.car(x=12.0, score=0.9), made.car(x=-12.0, score=0.1))
    results.add(CLEAN, NAMES)
    results.add(WEAK, NAMES)
    results.add(STRONG, NAMES, lost=NAMES[:3], extra=beside)
    results.add(AIMED, NAMES, extra=made.car(x=3.5, z=25.0, score=0.9))
    rows = {row.condition.attack: row for row in seen_rows(made.outcomes(results, NAMES), 0.3)}
    assert list(rows) == ["unattacked", "thesis_pgd-1", "patch-specific"]
    assert rows["unattacked"].cars_found.value == 1
    assert rows["thesis_pgd-1"].condition.strength == 4
    assert rows["thesis_pgd-1"].cars_found.value == pytest.approx(0.25)
    # One of two is too unsure to be planned on.
    assert (
        rows["thesis_pgd-1"].ghosts_in_lanes.value,
        rows["thesis_pgd-1"].ghosts_beside.value,
    ) == (
        0,
        1,
    )
    aimed = rows["patch-specific"]
    assert (aimed.ghosts_in_lanes.value, aimed.ghosts_beside.value, aimed.cars_found.value) == (
        1,
        0,
        1,
    )


def test_a_car_is_found_by_what_lies_on_it(made: ModuleType) -> None:
    truth = made.boxes(made.car(), made.car(x=6.0))
    assert found_cars(made.car(x=0.2), truth).tolist() == [True, False]
    assert found_cars(made.car(x=1.0), truth).tolist() == [False, False]
    assert found_cars(made.boxes(), truth).tolist() == [False, False]
