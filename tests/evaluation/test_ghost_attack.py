"""Random ghosts against procedural scenes."""

from __future__ import annotations

import json

import numpy as np
import pytest

from avsec_gym.attacks.object_injection import RandomGhosts
from avsec_gym.evaluation.ghost_attack import AttackedEpisode, ghost_attack, summary
from avsec_gym.pipeline import run_episode
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene_sets import procedural_scenes


@pytest.fixture(scope="module")
def episodes() -> list[AttackedEpisode]:
    return ghost_attack(procedural_scenes(20))


def test_safe_episodes_are_attacked_and_the_others_left_alone(
    episodes: list[AttackedEpisode],
) -> None:
    assert len(episodes) == 60
    for each in episodes:
        if not each.clean.safe:
            assert each.attacked is each.clean
            assert (each.queries, each.believed) == (0, each.scene.boxes)
            continue
        assert 1 <= each.queries <= 10
        assert len(each.believed) == len(each.scene.boxes) + 2
        again = run_episode(each.scene, each.intention, each.believed).record
        assert again.to_json() == each.attacked.to_json()
        assert each.attacked.safe <= (each.queries == 10)
    assert any(each.clean.safe and not each.attacked.safe for each in episodes)


def test_rates_and_differences_fit(episodes: list[AttackedEpisode]) -> None:
    report = json.loads(json.dumps(summary(episodes), allow_nan=False))
    rates = {(row["intention"], row["input"]): row for row in report["rates"]}
    assert len(rates) == 6
    for row in report["differences"]:
        clean = rates[row["intention"], "ground_truth"]
        attacked = rates[row["intention"], "ghost_attack"]
        assert (clean["scenarios"], attacked["scenarios"]) == (20, 20)
        change = attacked["safe_driving_rate"] - clean["safe_driving_rate"]
        assert row["safe_driving_rate"] == pytest.approx(change)
        assert row["became_safe"] == 0
        assert attacked["safe_driving_rate"] < clean["safe_driving_rate"]


def believed(episodes: list[AttackedEpisode]) -> bytes:
    return b"".join(each.believed.location.tobytes() for each in episodes)


def test_the_seed_decides_over_scenes_and_attack(episodes: list[AttackedEpisode]) -> None:
    assert believed(ghost_attack(procedural_scenes(20))) == believed(episodes)
    ghosts = [
        ghost_attack(procedural_scenes(20, seed=seed), intentions=[Intention.STRAIGHT])
        for seed in (1, 2)
    ]
    places = [
        {tuple(np.round(each.believed.poses[-1, :2], 6)) for each in some if each.queries == 1}
        for some in ghosts
    ]
    assert places[0]
    assert places[1]
    assert not places[0] & places[1]


def test_an_attacker_of_ones_own_and_progress() -> None:
    told: list[tuple[int, int]] = []
    weak = ghost_attack(
        procedural_scenes(4),
        attack=RandomGhosts(ghosts=1, queries=1),
        intentions=[Intention.LEFT],
        on_progress=lambda done, total: told.append((done, total)),
    )
    assert told == [(1, 4), (2, 4), (3, 4), (4, 4)]
    assert {each.queries for each in weak} <= {0, 1}
    assert {len(each.believed) - len(each.scene.boxes) for each in weak} <= {0, 1}
