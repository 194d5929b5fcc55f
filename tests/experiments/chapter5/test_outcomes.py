"""Conditions are compared on the scenarios that all of them have."""

from __future__ import annotations

from types import ModuleType

from avsec_gym.experiments.chapter5.outcomes import Condition, safe_by_scenario
from avsec_gym.planners.planner import Algorithm
from avsec_gym.scenario.intention import Intention

CLEAN, RCNN = Condition("dsgn"), Condition("stereo_rcnn")
WEAK, STRONG = Condition("dsgn", "thesis_pgd-0.4", 4.0), Condition("dsgn", "thesis_pgd-1", 1.0)
ROUNDED, AIMED = Condition("dsgn", "thesis_pgd-1", 1.0, True), Condition("dsgn", "patch-specific")


def test_conditions_stand_in_the_order_of_the_tables(made: ModuleType) -> None:
    results = made.MadeResults()
    for condition in (RCNN, ROUNDED, AIMED, STRONG, WEAK, CLEAN):
        results.add(condition, made.names(3))
    results.seen["dsgn no such attack", 0.0] = {}
    found = made.outcomes(results, made.names(3))
    assert found.conditions == (CLEAN, WEAK, STRONG, AIMED, ROUNDED, RCNN)
    assert ROUNDED.setting == "dsgn thesis_pgd-1 8-bit"
    assert found.looks(CLEAN) == (None,)
    assert found.looks(AIMED) == tuple(Intention)


def test_only_common_scenarios_count_and_hardly_begun_conditions_do_not(made: ModuleType) -> None:
    results, names = made.MadeResults(), made.names(10)
    results.add(CLEAN, names)
    results.add(WEAK, names[2:])
    results.add(STRONG, names[:3], unsafe=names[:3])
    found = made.outcomes(results, names)
    assert found.conditions == (CLEAN, WEAK)
    assert found.left_out == {STRONG: 3}
    assert found.scenarios == tuple(names[2:])
    assert len(found.records(CLEAN)) == len(found.records(WEAK)) == 8 * 3
    assert len(found.records(CLEAN, Intention.LEFT)) == len(found.detections(CLEAN)) == 8
    assert not found.records(RCNN)
    # Who has no labels cannot be judged.
    assert made.outcomes(results, names[4:]).scenarios == tuple(names[4:])


def test_a_run_on_the_ground_truth_alone_has_scenarios_too(made: ModuleType) -> None:
    results, names = made.MadeResults(), made.names(4)
    results.episodes["ground_truth", 0.0, "gbfs"] = [
        made.record(name, "left") for name in names[:3]
    ]
    found = made.outcomes(results, names)
    assert found.conditions == ()
    assert found.scenarios == tuple(names[:3])
    assert len(found.true_records(Algorithm.GBFS, Intention.LEFT)) == 3
    assert not found.true_records(Algorithm.ASTAR, Intention.LEFT)


def test_safe_drives_are_counted_by_scenario(made: ModuleType) -> None:
    records = [made.record("000001", "left"), made.record("000001", "right", "collision"),
               made.record("000000", "left", "unplanned")]  # fmt: skip
    assert safe_by_scenario(records, made.names(3)).tolist() == [[0, 1], [1, 2], [0, 0]]


def test_precision_is_that_of_what_was_seen_and_is_kept(made: ModuleType) -> None:
    results, names = made.MadeResults(), made.names(8)
    results.add(CLEAN, names)
    results.add(WEAK, names, lost=names)
    found = made.outcomes(results, names)
    assert found.precision(CLEAN).value("Car") > found.precision(WEAK).value("Car") == 0
    assert found.precision(CLEAN) is found.precision(CLEAN)
