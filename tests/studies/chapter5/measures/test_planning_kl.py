"""Planning KL divergence: worked out by hand, by brute force, and what follows from its meaning."""

from __future__ import annotations

from collections import defaultdict

import numpy as np
import pytest

from avsec_gym.metrics.collision_check import first_contact
from avsec_gym.planners.vehicle import BMW_320I
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.planning_scenario import PlanningScenario
from studies.chapter5.measures.planning_kl import (
    CELL,
    CONTACT,
    TEMPERATURE,
    planning_kl,
    summed_divergence,
)
from studies.chapter5.measures.trajectory_bundle import trajectory_bundle
from tests.metrics.test_contact_recall import scenario
from tests.studies.chapter5.measures.test_trajectory_bundle import BEHIND, CAR

WALL = ([15.0, 0.0, 0.0], 10.0, 20.0, 0.0)


def test_two_ways_by_hand() -> None:
    p, q = np.array([0.5, 0.5]), np.array([0.9, 0.1])
    apart = 0.5 * np.log(0.5 / 0.9) + 0.5 * np.log(0.5 / 0.1)
    # Together, apart, apart; in cells that one of them alone passes, and a third never.
    assert summed_divergence(p, q, np.array([[3, 3], [0, 1], [2, 0]])) == pytest.approx(2 * apart)
    assert summed_divergence(p, q, np.array([[3, 3]])) == 0
    # A way that the truth never takes adds nothing by itself.
    assert summed_divergence(np.array([1.0, 0.0]), q, np.array([[0, 1]])) == pytest.approx(
        np.log(1 / 0.9)
    )


def by_brute_force(truth: PlanningScenario, believed: PlanningScenario) -> float:
    """The definition, trajectory by trajectory, with dictionaries for cells."""
    bundle = trajectory_bundle(truth)
    chances = []
    for problem in (truth, believed):
        weights = []
        for states, length, cost in zip(bundle.states, bundle.lengths, bundle.cost, strict=True):
            touched = first_contact(states[:length], problem.obstacles, BMW_320I) is not None
            weights.append(np.exp(-(cost + CONTACT * touched) / TEMPERATURE))
        weights.append(np.exp(-3.0 / TEMPERATURE))
        chances.append(np.array(weights) / sum(weights))
    total = 0.0
    for t in range(1, bundle.states.shape[1]):
        own: dict[object, float] = defaultdict(float)
        other: dict[object, float] = defaultdict(float)
        for i, (p, q) in enumerate(zip(*chances, strict=True)):
            cell: object = "stopped"
            if i < len(bundle.states):
                x, y = bundle.states[i, min(t, bundle.lengths[i] - 1), :2]
                cell = (x // CELL, y // CELL)
            own[cell] += p
            other[cell] += q
        total += sum(own[cell] * np.log(own[cell] / other[cell]) for cell in own)
    return total


def test_it_is_the_definition_trajectory_by_trajectory() -> None:
    truth = scenario(CAR, road_type=RoadType.HIGHWAY, intention=Intention.LEFT)
    believed = scenario(
        ([13.0, 2.5, 0.0], 4.0, 1.8, 0.0), road_type=RoadType.HIGHWAY, intention=Intention.LEFT
    )
    expected = by_brute_force(truth, believed)
    assert expected > 1
    assert planning_kl(truth, believed) == pytest.approx(expected, rel=1e-6)


def test_what_is_not_on_the_way_costs_nothing() -> None:
    truth = scenario(CAR)
    assert planning_kl(truth, truth) == 0
    assert planning_kl(truth, scenario(CAR, BEHIND)) == 0
    assert planning_kl(truth, scenario()) > 1
    assert planning_kl(scenario(), truth) > 1


def test_a_box_a_little_aside_costs_less_than_one_that_is_missed() -> None:
    truth = scenario(([14.0, 2.2, 0.0], 4.0, 1.8, 0.0))
    aside = scenario(([14.0, 2.3, 0.0], 4.0, 1.8, 0.0))
    assert 0 < planning_kl(truth, aside) < 0.3 * planning_kl(truth, scenario())


def test_a_car_that_can_only_give_up_differs_from_one_that_drives() -> None:
    free, blocked = scenario(), scenario(WALL)
    # Nearly all drive by one belief and stop by the other: (3.0 - 1.7) / T nats a step or more.
    assert planning_kl(free, blocked) > 20 * 5
    assert planning_kl(blocked, free) > 20 * 5
    assert planning_kl(blocked, scenario(WALL, CAR)) == pytest.approx(0, abs=1e-6)
