"""Planners that keep their trees for pictures."""

from __future__ import annotations

from avsec_gym.planners.kept_tree import with_tree
from avsec_gym.planners.plan import Plan
from avsec_gym.planners.planner import Algorithm, MotionPrimitivePlanner
from avsec_gym.scenario.planning_scenario import PlanningScenario


class Another:
    """A planner that keeps nothing."""

    def plan(self, scenario: PlanningScenario) -> Plan:
        raise NotImplementedError


def test_a_planner_by_primitives_keeps_its_tree_and_all_else() -> None:
    planner = MotionPrimitivePlanner(Algorithm.GBFS, node_limit=7)
    kept = with_tree(planner)
    assert kept == MotionPrimitivePlanner(Algorithm.GBFS, node_limit=7, keep_tree=True)
    assert not planner.keep_tree


def test_another_planner_stays_as_it_is() -> None:
    planner = Another()
    assert with_tree(planner) is planner
