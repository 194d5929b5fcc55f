"""Contested scenes: unsafe for a blind car, safe for one that sees all."""

from __future__ import annotations

import inspect
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.evaluation.contested import (
    ChosenFrames,
    contested,
    contested_layouts,
    is_contested,
)
from avsec_gym.evaluation.rates import GROUND_TRUTH, RatesKey, driving_safety
from avsec_gym.geometry import ego_to_camera
from avsec_gym.pipeline import run_episode
from avsec_gym.scenario.contested_sets import ContestedSets, contested_sets
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Motion, Scene
from avsec_gym.scenario.scene_set import SceneSet
from avsec_gym.scenario.scene_sets import procedural_scenes, scene_set


def scene(id: str, *poses: list[float]) -> Scene:
    location, rotation_y = ego_to_camera(np.array(poses, float).reshape(-1, 3), 1.65)
    count = len(rotation_y)
    size, category = np.tile([1.5, 1.6, 4.0], (count, 1)), np.full(count, "Car")
    return Scene(id, Boxes3D(location, size, rotation_y, np.ones(count), category))


BESIDE = scene("left", [13.0, 3.5, 0.0])
"""In the way of who changes to the left lane."""
WALL = scene("wall", *([12.0, y, 0.0] for y in (-3.5, 0.0, 3.5)))
"""Neither blind nor seeing is there a safe way."""
EMPTY = scene("empty")


def test_scenes_find_here_what_they_ask_for() -> None:
    """They name this module by a string, which no checker of types or imports follows."""
    for name in ("contested", "contested_layouts", "contested_frames"):
        asked = inspect.signature(getattr(ContestedSets, name)).parameters
        known = inspect.signature(getattr(contested_sets(), name)).parameters
        for argument in asked.keys() - {"self"}:
            assert known[argument].kind == asked[argument].kind
            assert known[argument].default == asked[argument].default
        others = [known[argument] for argument in known.keys() - asked.keys()]
        assert all(each.default is not each.empty for each in others)


def test_the_rule_by_hand() -> None:
    assert [is_contested(BESIDE, way) for way in Intention] == [True, False, False]
    for other in (WALL, EMPTY):
        assert not any(is_contested(other, way) for way in Intention)
    chosen = contested(SceneSet("three", (BESIDE, WALL, EMPTY)))
    assert chosen.scenes == (BESIDE,)
    assert chosen.intentions == {"left": frozenset({Intention.LEFT})}
    with pytest.raises(ConfigurationError, match="none of the 1 scenes of one is contested"):
        contested(SceneSet("one", (EMPTY,)))


def test_the_procedural_set_holds_the_first_layouts_that_are() -> None:
    scenes = contested_layouts(5)
    assert scenes.intentions is not None
    every = {each.id: each for each in procedural_scenes(48).labelled}
    for each in scenes.labelled:
        same = every.pop(each.id)
        assert {way for way in Intention if is_contested(same, way)} == scenes.intentions[each.id]
    last = scenes.labelled[-1].number
    before = [other for other in every.values() if other.number < last]
    assert not any(is_contested(other, way) for other in before for way in Intention)


def test_names_stand_for_sets(tmp_path: Path) -> None:
    named = scene_set("mixed_contested", count=3)
    assert (len(named), named.name) == (3, "mixed_contested")
    assert [s.id for s in named.scenes] == [s.id for s in contested_layouts(3).scenes]
    with pytest.raises(ConfigurationError, match="labels in a folder: name it with --kitti"):
        scene_set("kitti_contested")
    with pytest.raises(ConfigurationError, match='Did you mean "mixed_contested"'):
        scene_set("mixed_contestd")


def test_rates_count_the_intentions_that_are_contested() -> None:
    """A seeing car is safe in all of them, a blind one in none."""
    scenes = scene_set("mixed_contested", count=8)
    result = driving_safety(scenes, truth_motion=Motion.STATIC)
    assert scenes.intentions is not None
    counts = 0
    for way in Intention:
        rates = result.rates(RatesKey("astar", str(way), GROUND_TRUTH))
        counts += rates.scenarios
        assert rates.planned - rates.collisions == rates.scenarios
    assert counts == sum(map(len, scenes.intentions.values())) < 24
    for each in scenes.labelled:
        for way in scenes.intentions[each.id]:
            blind = run_episode(each, way, Boxes3D.empty(), motion=Motion.STATIC)
            assert not blind.record.safe


@pytest.mark.slow
def test_the_labelled_scenarios_have_contested_ones(shared: Path) -> None:
    folder = shared / "safety_scenarios"
    named = scene_set("kitti_contested", kitti=folder)
    as_argument = scene_set(folder, contested=True)
    assert named.intentions == as_argument.intentions
    assert len(named) > 100


def test_frames_are_rendered_of_the_same_layouts() -> None:
    recipe = ChosenFrames("mixed", 9, 0, numbers=(6, 12))
    assert recipe.last_file(1) == "training/label_2/000012.txt"
    assert recipe.settings != ChosenFrames("mixed", 12, 1, numbers=(6, 12)).settings
