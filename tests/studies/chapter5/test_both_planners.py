"""GBFS on the same detections: its episodes are those of the planner itself, its sums by hand."""

from __future__ import annotations

import json
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

from avsec_gym.experiments.chapter5.outcomes import RESAMPLES, Condition, Outcomes
from avsec_gym.experiments.json_rows import row_json, row_of
from avsec_gym.metrics.cluster_bootstrap import draw_resamples
from avsec_gym.pipeline import run_episode
from avsec_gym.planners.planner import Algorithm, MotionPrimitivePlanner
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Motion, Scene
from studies.chapter5.both_planners import BothPlanners, both_planners, page
from studies.chapter5.replanned_results import replanned

CLEAN, AIMED = Condition("dsgn"), Condition("dsgn", "patch-specific")
PERTURBED = tuple(Condition("dsgn", "thesis_pgd-1", float(n)) for n in (1, 2, 3, 4))
COUNT = 10


def study(made: ModuleType) -> tuple[Outcomes, Any, BothPlanners]:
    """Seen are cars or nothing, with ghosts under the patch; A* is told to be safe throughout."""
    results, names = made.MadeResults(), made.names(COUNT)
    results.add(CLEAN, names)
    for number, condition in enumerate(PERTURBED):
        results.add(condition, names, lost=names[: 2 * number + 1])
    results.add(AIMED, names)
    for way in Intention:
        wall = [made.car(x=x, z=9.0, score=0.9) for x in (-4.0, -2.0, 0.0, 2.0, 4.0)]
        ghosts = made.boxes(*(wall if way == Intention.LEFT else []))
        results.seen[f"dsgn patch-specific-{way}", 0.0] = dict.fromkeys(names, ghosts)
    places = {name: made.car(x=-3.5, z=9.0 + number) for number, name in enumerate(names)}
    outcomes = Outcomes(results, places)
    scenes = SimpleNamespace(
        scenes=SimpleNamespace(
            labelled=[Scene(name, boxes, "street") for name, boxes in places.items()]
        )
    )
    return outcomes, scenes, both_planners(outcomes, scenes, Motion.STATIC, 0.3)


def safe_with_gbfs(outcomes: Outcomes, scenes: Any, condition: Condition) -> np.ndarray:
    """Scenario by scenario, intention by intention."""
    planner, looks = MotionPrimitivePlanner("gbfs"), outcomes.looks(condition)
    found = []
    for number, scene in enumerate(scenes.scenes.labelled):
        for column, way in enumerate(Intention):
            look = looks[column] if len(looks) > 1 else looks[0]
            seen = outcomes.detections(condition, look)[number]
            episode = run_episode(scene, way, seen, motion=Motion.STATIC, planner=planner)
            found.append(episode.record.safe)
    return np.array(found).reshape(COUNT, 3)


def test_episodes_of_gbfs_are_those_of_the_planner(made: ModuleType) -> None:
    outcomes, scenes, found = study(made)
    rows = {(row.condition, row.planner): row for row in found.rows}
    assert len(rows) == 2 * (2 + len(PERTURBED))
    for condition in (CLEAN, *PERTURBED, AIMED):
        safe = safe_with_gbfs(outcomes, scenes, condition)
        row = rows[condition, "gbfs"]
        assert row.rates.safe_driving_rate == pytest.approx(safe.mean())
        assert list(row.by_intention.values()) == pytest.approx(safe.mean(axis=0).tolist())
        assert rows[condition, "astar"].rates.safe_driving_rate == 1
    assert rows[AIMED, "gbfs"].rates.safe_driving_rate < 1


def test_differences_are_paired_over_scenarios(made: ModuleType) -> None:
    outcomes, scenes, found = study(made)
    draws = draw_resamples(COUNT, RESAMPLES, 0)
    by_scenario = {
        condition: 100 * safe_with_gbfs(outcomes, scenes, condition).mean(axis=1)
        for condition in (CLEAN, AIMED)
    }
    row = next(row for row in found.differences if row.condition == AIMED)
    assert row.more_safe.value == pytest.approx(by_scenario[AIMED].mean() - 100)
    np.testing.assert_allclose(
        row.more_safe.interval,
        np.quantile(draws @ by_scenario[AIMED] / COUNT - 100, [0.025, 0.975]),
    )
    lost = by_scenario[CLEAN] - by_scenario[AIMED]
    assert row.more_lost.value == pytest.approx(lost.mean())
    np.testing.assert_allclose(
        row.more_lost.interval, np.quantile(draws @ lost / COUNT, [0.025, 0.975])
    )
    clean = next(row for row in found.differences if row.condition == CLEAN)
    assert clean.more_lost.value is None


def test_the_question_is_asked_with_each_planner(made: ModuleType) -> None:
    outcomes, scenes, found = study(made)
    assert list(found.families) == ["astar", "gbfs"]
    perturbations = {
        planner: next(row for row in families.rows if row.family == "perturbations")
        for planner, families in found.families.items()
    }
    # A* never loses; with GBFS the same precision costs something.
    assert perturbations["astar"].safety_lost.value == 0
    clean = safe_with_gbfs(outcomes, scenes, CLEAN).mean()
    taken = [clean - safe_with_gbfs(outcomes, scenes, each).mean() for each in PERTURBED]
    assert perturbations["gbfs"].safety_lost.value == pytest.approx(100 * np.mean(taken))
    assert perturbations["gbfs"].precision_lost.value == perturbations["astar"].precision_lost.value


def test_the_page_is_made_of_the_json(made: ModuleType) -> None:
    _, _, found = study(made)
    again = row_of(BothPlanners, json.loads(json.dumps(row_json(found), allow_nan=False)))
    text = page(again, "command")
    assert text == page(found, "command")
    assert "| DSGN | specific patch | GBFS |" in text
    assert "| DSGN | specific patch | A* |" in text
    assert "the planners surely differ" in text


def test_episodes_of_other_conditions_are_not_the_runs(made: ModuleType) -> None:
    outcomes, _, _ = study(made)
    records = [made.record(name, way) for name in made.names(COUNT) for way in Intention]
    other = replanned(outcomes, {PERTURBED[0]: records}, Algorithm.GBFS)
    assert other.conditions == (PERTURBED[0],)
    assert other.records(CLEAN) == []
    assert len(other.records(PERTURBED[0], Intention.LEFT)) == COUNT
    assert other.results.records(planner="gbfs") == other.records(PERTURBED[0])
    assert other.results.records(planner="astar") == []
