"""Frames of the procedural world for one experiment: which ones, and where they are kept."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments import procedural_frames as module
from avsec_gym.experiments.chapter5 import scenes
from avsec_gym.experiments.procedural_frames import PROCEDURAL, procedural_frames
from avsec_gym.runs.experiment import Configuration


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
        # The package's networks were trained on such sets of seed 1, and chosen on that of 0.
        assert recipe.seed > 100


def test_what_cannot_be_is_refused(asked: dict[str, Any]) -> None:
    for count, seed in ((0, 0), (2, -1), (10**23, 0)):
        with pytest.raises(ConfigurationError):
            procedural_frames(count, seed)
    assert not asked


def test_a_run_takes_them_by_limit_and_seed(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []
    monkeypatch.setattr(scenes, "procedural_frames", lambda *given: asked.append(given) or "there")
    monkeypatch.setattr(scenes, "frame_scenes", lambda *given, **more: (given, more))
    scenes._scenes.cache_clear()
    found = scenes.scenes_of(Configuration(PROCEDURAL, 5, 7))
    scenes._scenes.cache_clear()
    assert asked == [(5, 7)]
    assert found == (("there",), {"count": 5, "seed": 7})
