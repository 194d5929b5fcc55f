"""Rows of the thesis' tables hold our figures where they belong, and the thesis' beside them."""

from __future__ import annotations

from types import ModuleType

import pytest

from avsec_gym.experiments.chapter5.outcomes import Condition
from avsec_gym.experiments.chapter5.tables import (
    input_rows,
    placement_rows,
    planner_rows,
    precision_rows,
    safety_rows,
)
from avsec_gym.experiments.thesis import ThesisRates
from avsec_gym.scenario.intention import Intention

CLEAN, PGD = Condition("stereo_rcnn"), Condition("stereo_rcnn", "thesis_pgd-1", 4.0)
RANDOM, AIMED = (Condition("stereo_rcnn", f"patch-{how}") for how in ("random", "specific"))
NAMES = [f"{number:06d}" for number in range(6)]


@pytest.fixture
def found(made: ModuleType):  # type: ignore[no-untyped-def]
    results = made.MadeResults()
    results.add(CLEAN, NAMES)
    results.add(PGD, NAMES, lost=NAMES, unsafe=NAMES[:2])
    results.add(RANDOM, NAMES)
    results.add(AIMED, NAMES, unsafe=NAMES[:3], outcome="unplanned")
    # The patch stands left, straight, right, left, ...; episodes fail where they go there.
    aims = {name: number % 3 for number, name in enumerate(NAMES)}
    results.measure(RANDOM, "attack_intention", aims)
    results.episodes[RANDOM.setting, 0.0, "astar"] = [
        made.record(name, way, "unplanned" if list(Intention)[aim] == way else "safe", "limit")
        for name, aim in aims.items()
        for way in Intention
    ]
    for planner in ("astar", "gbfs"):
        results.episodes["ground_truth", 0.0, planner] = [
            made.record(name, way) for name in [*NAMES, "000099"] for way in Intention
        ]
    return made.outcomes(results, NAMES)


def test_safety_is_told_by_intention_with_the_thesis_and_paired(found) -> None:  # type: ignore[no-untyped-def]
    rows = {(row.condition.attack, row.intention): row for row in safety_rows(found)}
    assert len(rows) == 4 * 3
    row = rows["thesis_pgd-1", "straight"]
    assert row.rates.safe_driving_rate == pytest.approx(4 / 6)
    assert row.rates.collision_rate == pytest.approx(2 / 6)
    assert row.thesis == ThesisRates(0.906, 0.035, 0.874)
    assert (row.paired.became_unsafe, row.paired.became_safe) == (2, 0)
    assert row.paired.mcnemar_p == 0.5
    # Nine rows of attacks: three of the specific patch count first, with 0.25 each.
    assert row.mcnemar_p_holm == 1
    assert rows["unattacked", "left"].thesis.safe == 0.87


def test_a_random_patch_is_split_by_where_the_car_goes(found) -> None:  # type: ignore[no-untyped-def]
    rows = {row.group: row for row in placement_rows(found)}
    assert {name: row.rates.scenarios for name, row in rows.items()} == {
        "unattacked": 18, "same": 6, "different": 12, "specific": 18,
    }  # fmt: skip
    assert rows["same"].rates.safe_driving_rate == 0
    assert rows["different"].rates.safe_driving_rate == 1
    assert rows["specific"].rates.safe_driving_rate == 0.5
    assert rows["same"].thesis.safe == 0.744


def test_precision_of_a_specific_patch_is_that_of_each_intention(found) -> None:  # type: ignore[no-untyped-def]
    rows = precision_rows(found)
    aimed = [row for row in rows if row.condition.attack == "patch-specific"]
    assert [row.intention for row in aimed] == ["left", "straight", "right"]
    assert aimed[0].thesis == (0.4814, 0.3627, 0.3121)
    pgd = next(row for row in rows if row.condition.attack == "thesis_pgd-1")
    assert pgd.precision["3d"]["ap11"] == [0, 0, 0]
    assert pgd.thesis is None


def test_searches_and_inputs_are_compared_on_the_same_scenarios(found) -> None:  # type: ignore[no-untyped-def]
    assert {row.rates.scenarios for row in planner_rows(found)} == {6}
    rows = [row for row in input_rows(found) if row.intention == "left"]
    assert [(row.detector, row.attack) for row in rows] == [
        (None, "unattacked"), ("stereo_rcnn", "unattacked"), ("stereo_rcnn", "thesis_pgd-1"),
        ("stereo_rcnn", "patch-random"),
    ]  # fmt: skip
    assert [row.thesis for row in rows] == [0.897, 0.87, 0.792, 0.689]
