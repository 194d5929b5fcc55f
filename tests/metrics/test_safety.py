"""Records and the thesis' three rates."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from avsec_gym.experiments.json_rows import row_of
from avsec_gym.metrics.intervals import wilson_interval
from avsec_gym.metrics.safety import (
    COLLISION,
    SAFE,
    UNPLANNED,
    SafetyRates,
    SafetyRecord,
    judge,
)
from avsec_gym.planners.plan import Plan, Reason, Status
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.planning_scenario import EgoState, Goal, PlanningScenario

NAN = math.nan


def record(outcome: str, reason: str | None = None, length: float = 10.0) -> SafetyRecord:
    planned = outcome != UNPLANNED
    return SafetyRecord(
        "000107", "left", outcome, 2.0 if planned else NAN, 5, length if planned else NAN,
        2.0 if planned else NAN, reason,
    )  # fmt: skip


def test_rates_by_hand() -> None:
    records = [
        *[record(SAFE, length=12.0)] * 6,
        *[record(COLLISION, length=20.0)] * 2,
        record(UNPLANNED, "goal_occupied"),
        record(UNPLANNED, "unreachable"),
        record(UNPLANNED, "unreachable"),
        record(UNPLANNED, "limit"),
    ]
    rates = SafetyRates.of(replace(each, scenario=str(n)) for n, each in enumerate(records))
    assert rates.success_rate == 8 / 12
    assert rates.collision_rate == 2 / 8
    assert rates.safe_driving_rate == 6 / 12
    assert rates.failures == {"goal_occupied": 1, "limit": 1, "unreachable": 2}
    assert rates.mean_path_length == 14.0
    report = rates.to_json()
    assert report["collision_rate_interval"] == list(wilson_interval(2, 8))
    assert report["success_rate_interval"] == list(wilson_interval(8, 12))
    assert report["safe_driving_rate_interval"] == list(wilson_interval(6, 12))
    assert (report["scenarios"], report["planned"], report["collisions"]) == (12, 8, 2)


@given(st.integers(0, 40), st.integers(0, 40), st.integers(0, 40))
def test_the_thesis_identity(safe: int, collided: int, unplanned: int) -> None:
    """m_saf = (1 - m_cls) m_suc"""
    records = [record(SAFE)] * safe + [record(COLLISION)] * collided
    rates = SafetyRates.of(iter(records + [record(UNPLANNED, "limit")] * unplanned))
    if records:
        product = (1 - rates.collision_rate) * rates.success_rate
        assert rates.safe_driving_rate == pytest.approx(product, abs=1e-12)
    assert sum(rates.failures.values()) == unplanned


def test_a_rate_without_cases_is_null() -> None:
    nothing, unplanned = SafetyRates.of([]).to_json(), SafetyRates.of([record(UNPLANNED)]).to_json()
    for name in ("success_rate", "collision_rate", "safe_driving_rate"):
        assert nothing[name] is None
        assert nothing[f"{name}_interval"] is None
    assert unplanned["success_rate"] == unplanned["safe_driving_rate"] == 0.0
    assert unplanned["collision_rate"] is None
    assert unplanned["collision_rate_interval"] is None
    assert unplanned["mean_path_length"] is None
    assert unplanned["mean_travel_time"] is None
    json.dumps([nothing, unplanned], allow_nan=False)


def test_intentions_of_one_scene_are_a_cluster() -> None:
    """Three alike in each of ten scenes say as much as ten; three of thirty scenes say more."""
    outcomes = [SAFE] * 6 + [COLLISION] * 3 + [UNPLANNED]
    shared = [
        replace(record(outcome), scenario=str(scene))
        for scene, outcome in enumerate(outcomes)
        for _ in range(3)
    ]
    apart = [replace(each, scenario=str(number)) for number, each in enumerate(shared)]
    clustered, alone = (SafetyRates.of(records).to_json() for records in (shared, apart))
    for name, hits, cases in (
        ("success_rate", 9, 10), ("collision_rate", 3, 9), ("safe_driving_rate", 6, 10),
    ):  # fmt: skip
        assert clustered[name] == alone[name]
        assert clustered[f"{name}_interval"] == pytest.approx(wilson_interval(hits, cases))
        assert alone[f"{name}_interval"] == pytest.approx(wilson_interval(3 * hits, 3 * cases))
    assert "design_effects" not in alone
    assert row_of(SafetyRates, clustered).to_json() == clustered
    # Scenarios of one drive belong together, too.
    by_drive = SafetyRates.of(apart, lambda each: str(int(each.scenario) // 3)).to_json()
    assert by_drive == clustered
    json.dumps(SafetyRates.of([]).to_json(), allow_nan=False)


def test_a_record_is_json_and_knows_its_outcome() -> None:
    one = record(UNPLANNED, "limit")
    assert (one.planned, one.collision, one.safe) == (False, False, False)
    text = one.to_json()
    json.dumps(text, allow_nan=False)
    assert (text["cost"], text["reason"], text["collision_object"]) == (None, "limit", None)
    two = record(COLLISION)
    assert (two.planned, two.collision, two.safe) == (True, True, False)


def problem(**fields: object) -> PlanningScenario:
    goal = Goal((4, 30))
    return PlanningScenario("a", EgoState(), (goal,), intention=Intention.LEFT, **fields)  # type: ignore[arg-type]


def drive() -> np.ndarray:
    states = np.zeros((21, 5))
    states[:, 0], states[:, 2] = np.arange(21), 10.0
    return states


def test_a_plan_is_judged_against_the_truth_not_against_what_was_believed() -> None:
    wall = Obstacles.rectangles(np.array([[15.0, 0, 0]]), np.ones(1), np.ones(1))
    plan = Plan(Status.FOUND, drive(), cost=2.0, expanded=7)
    assert judge(plan, problem(obstacles=wall), Obstacles.none()).outcome == SAFE
    blind = judge(plan, problem(), wall)
    assert blind.outcome == COLLISION
    assert blind.collision_object == 0
    # The front is at 14.5 m when the centre is at 12.246 m: at x = 13, after 1.3 s.
    assert blind.collision_time == pytest.approx(1.3)
    assert (blind.cost, blind.expanded, blind.intention, blind.scenario) == (2.0, 7, "left", "a")
    assert (blind.path_length, blind.travel_time) == (pytest.approx(20.0), pytest.approx(2.0))


def test_times_count_from_the_start_of_the_trajectory() -> None:
    wall = Obstacles.rectangles(np.array([[15.0, 0, 0]]), np.ones(1), np.ones(1))
    plan = Plan(Status.FOUND, drive(), first_step=8)
    assert judge(plan, problem(), wall).collision_time == pytest.approx(1.3)


def test_no_plan_keeps_its_reason() -> None:
    plan = Plan(Status.EXHAUSTED, reason=Reason.GOAL_OCCUPIED, goal_occupied=2.7, expanded=3)
    one = judge(plan, problem(), Obstacles.none())
    assert (one.outcome, one.reason, one.goal_occupied) == (UNPLANNED, "goal_occupied", 2.7)
    assert math.isnan(one.cost)
    assert math.isnan(one.collision_time)
