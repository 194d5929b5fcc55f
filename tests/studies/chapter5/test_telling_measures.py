"""A measure of what is in reach tells of safety where average precision tells of what is far."""

from __future__ import annotations

from types import ModuleType

import numpy as np
import pytest
from scipy.stats import spearmanr

from avsec_gym.experiments.chapter5.outcomes import Condition, Outcomes
from studies.chapter5.telling_measures import MEASURES, PRECISION, MeasureRow, telling_rows

CLEAN = Condition("dsgn")
ATTACKS = tuple(Condition("dsgn", "thesis_pgd-1", float(n)) for n in (1, 2, 3, 4))
NAMES = [f"{number:06d}" for number in range(40)]
NEAR_LOST, FAR_LOST = (2, 6, 9, 12), (30, 20, 10, 0)


def rows_of(made: ModuleType, drift: float = 0.0) -> dict[tuple[str, str], MeasureRow]:
    """A car in reach and one beyond; drives are unsafe where the near one is lost."""
    near, far = made.car(z=12.0, score=0.9), made.car(z=35.0, score=0.9)
    seen_near = made.car(x=drift, z=12.0, score=0.9)
    results = made.MadeResults()
    results.add(CLEAN, NAMES)
    results.seen[CLEAN.setting, 0.0] = {name: made.boxes(seen_near, far) for name in NAMES}
    for attack, lost, lost_far in zip(ATTACKS, NEAR_LOST, FAR_LOST, strict=True):
        results.add(attack, NAMES, unsafe=NAMES[:lost])
        results.seen[attack.setting, attack.strength] = {
            name: made.boxes(
                *([seen_near] if number >= lost else []), *([far] if number >= lost_far else [])
            )
            for number, name in enumerate(NAMES)
        }
    outcomes = Outcomes(results, {name: made.boxes(near, far) for name in NAMES})
    return {(row.measure, row.detector): row for row in telling_rows(outcomes, 0.3)}


def test_cars_in_reach_tell_what_all_cars_do_not(made: ModuleType) -> None:
    rows = rows_of(made)
    assert {measure for measure, _ in rows} == set(MEASURES)
    reach, every = rows["cars in reach found", "dsgn"], rows["cars found", "dsgn"]
    assert reach.attacks == 4
    assert reach.rho == pytest.approx(1)
    both_lost = np.add(NEAR_LOST, FAR_LOST)
    assert every.rho == pytest.approx(spearmanr(both_lost, NEAR_LOST).statistic)
    assert rows[PRECISION, "both"].more.value == 0
    assert reach.more.value == pytest.approx(1 - rows[PRECISION, "dsgn"].rho)
    low, high = reach.more.interval
    assert low <= reach.more.value <= high


def test_a_box_beside_its_car_counts_as_found_but_not_as_precise(made: ModuleType) -> None:
    drifted = rows_of(made, drift=0.8)
    assert drifted["cars in reach found", "dsgn"].rho == pytest.approx(1)
    assert drifted[PRECISION, "dsgn"].rho != pytest.approx(1)
