"""Frames of the procedural world for one experiment: which ones, and where they are kept."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.evaluation.contested import is_contested
from avsec_gym.experiments import procedural_frames as module
from avsec_gym.experiments.chapter5 import scenes
from avsec_gym.experiments.procedural_frames import CONTESTED, PROCEDURAL, procedural_frames
from avsec_gym.runs.experiment import Configuration
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene_sets import scene_of_layout
from avsec_gym.world.layouts import generate_layout


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """What the cache is asked for, by the folder's name."""
    found: dict[str, Any] = {}
    monkeypatch.setattr(
        module, "cached", lambda name, recipe: Path(found.setdefault(name, recipe) and name)
    )
    return found


def test_each_number_and_seed_has_a_folder_and_scenes_of_its_own(asked: dict[str, Any]) -> None:
    folders = [procedural_frames(*choice) for choice in ((None, 0), (12, 1), (3, 0))]
    assert len(set(folders)) == 3
    assert [len(recipe) for recipe in asked.values()] == [12, 12, 3]
    assert len({recipe.seed for recipe in asked.values()}) == 2
    for recipe in asked.values():
        assert recipe.settings["cameras"] == [2, 3]
        assert not recipe.settings["lidar"]
        assert recipe.settings["assets"] == "judge"
        # The package's networks were trained on such sets of seed 1, and chosen on that of 0.
        assert recipe.seed > 100


def test_what_cannot_be_is_refused(asked: dict[str, Any]) -> None:
    for count, seed in ((0, 0), (2, -1), (10**23, 0)):
        with pytest.raises(ConfigurationError):
            procedural_frames(count, seed)
    assert not asked


def test_contested_ones_are_those_of_their_set_that_are(asked: dict[str, Any]) -> None:
    assert procedural_frames(2, 5) != procedural_frames(2, 5, contested=True)
    every, chosen = asked.values()
    assert chosen.settings == every.settings | {"chosen": "contested"}
    assert len(chosen) == len(chosen.numbers) == 2
    for number in range(chosen.numbers[-1] + 1):
        scene = scene_of_layout(generate_layout(number, set_seed=chosen.seed), chosen.seed)
        matters = any(is_contested(scene, way) for way in Intention)
        assert matters == (number in chosen.numbers)


@pytest.mark.parametrize("place", [PROCEDURAL, CONTESTED])
def test_a_run_takes_them_by_limit_and_seed(monkeypatch: pytest.MonkeyPatch, place: str) -> None:
    asked: list[Any] = []

    def frames(*given: Any, contested: bool) -> str:
        asked.append((*given, contested))
        return "there"

    monkeypatch.setattr(scenes, "procedural_frames", frames)
    monkeypatch.setattr(scenes, "frame_scenes", lambda *given, **more: (given, more))
    scenes._scenes.cache_clear()
    found = scenes.scenes_of(Configuration(place, 5, 7))
    scenes._scenes.cache_clear()
    assert asked == [(5, 7, place == CONTESTED)]
    assert found == (("there",), {"count": 5, "seed": 7})
