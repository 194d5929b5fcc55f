"""Figures of contested scenes are those of the episodes in which it matters what a car sees."""

from __future__ import annotations

from types import ModuleType

import pytest

from avsec_gym.evaluation.contested import is_contested
from avsec_gym.experiments.chapter5.contested_scenes import (
    contested_episodes,
    contested_figures,
    contested_outcomes,
)
from avsec_gym.experiments.chapter5.losses import losses
from avsec_gym.experiments.chapter5.outcomes import Condition, Outcomes
from avsec_gym.experiments.json_rows import row_json
from avsec_gym.metrics.average_precision import average_precision
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Scene

CLEAN, ATTACK = Condition("dsgn"), Condition("dsgn", "thesis_pgd-1", 4.0)
FEW = Condition("dsgn", "patch-random")
COUNT, NEAR = 8, 3


def outcomes_and_scenes(made: ModuleType) -> tuple[Outcomes, list[Scene]]:
    """In the first scenes a car stands beside the goal's lane; in the others all is far."""
    names = made.names(COUNT)
    labels = {
        name: made.car(x=-3.5, z=13.0) if number < NEAR else made.car(z=45.0)
        for number, name in enumerate(names)
    }
    results = made.MadeResults()
    results.add(CLEAN, names)
    results.add(ATTACK, names, unsafe=names[1:6])
    results.seen[CLEAN.setting, 0.0] = {
        name: made.boxes(labels[name]) for name in names
    }  # All is found.
    results.seen[ATTACK.setting, 4.0] = {
        name: labels[name] if number in (0, 4) else made.boxes()
        for number, name in enumerate(names)
    }
    # Done for the contested scenes alone: too few of all.
    results.add(FEW, names[:NEAR])
    scenes = [
        Scene(name, boxes, "street", number=number)
        for number, (name, boxes) in enumerate(labels.items())
    ]
    return Outcomes(results, labels), scenes


def test_only_episodes_that_the_rule_contests_count(made: ModuleType) -> None:
    outcomes, scenes = outcomes_and_scenes(made)
    assert len(outcomes.scenarios) == COUNT
    episodes = contested_episodes(outcomes, scenes[::-1])
    assert episodes == {
        (scene.id, str(way)) for scene in scenes for way in Intention if is_contested(scene, way)
    }
    assert episodes == {(scene.id, "left") for scene in scenes[:NEAR]}
    within = contested_outcomes(outcomes, episodes)
    assert within.scenarios == tuple(scene.id for scene in scenes[:NEAR])
    assert within.conditions == outcomes.conditions == (CLEAN, ATTACK)
    assert [record.safe for record in within.records(ATTACK)] == [True, False, False]


def test_losses_of_contested_scenes_by_hand(made: ModuleType) -> None:
    outcomes, scenes = outcomes_and_scenes(made)
    found = contested_figures(outcomes, scenes)
    assert found is not None
    assert (found.scenarios, found.episodes) == (NEAR, NEAR)
    rates = {(row.condition, row.contested): row.rates for row in found.rates}
    assert rates[ATTACK, True].safe_driving_rate == pytest.approx(1 / 3)
    assert rates[ATTACK, False].safe_driving_rate == pytest.approx(3 / 8)
    assert rates[CLEAN, True].safe_driving_rate == rates[CLEAN, False].safe_driving_rate == 1
    assert rates[ATTACK, False].scenarios == 3 * COUNT
    # The three episodes of a scene turn together: they count for one.
    assert rates[ATTACK, False].design_effects["safe_driving_rate"] > 1.5
    (row,) = found.decoupling.attacks
    assert row.safety_lost.value == pytest.approx(100 * 2 / 3)
    labels = list(outcomes.labels.values())[:NEAR]
    seen = outcomes.detections(ATTACK)[:NEAR]
    alone = [average_precision(labels, boxes, classes=("Car",)) for boxes in (labels, seen)]
    assert row.precision_lost.value == pytest.approx(alone[0].value("Car") - alone[1].value("Car"))
    (everywhere,) = losses(outcomes)
    assert everywhere.safety.value == pytest.approx(100 * 5 / 8)
    assert found.families.rows[0].safety_lost == row.safety_lost
    assert set(row_json(found)) == {"scenarios", "episodes", "rates", "decoupling", "families"}


def test_where_nothing_is_contested_there_are_no_figures(made: ModuleType) -> None:
    outcomes, scenes = outcomes_and_scenes(made)
    far = scenes[NEAR:]
    labels = {scene.id: scene.boxes for scene in far}
    assert contested_figures(Outcomes(outcomes.results, labels), far) is None
