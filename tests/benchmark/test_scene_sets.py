"""The frozen scenes: the same in every release that has this version."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.benchmark.scene_sets import Extent, FrozenSet, digest_of, frozen_sets
from avsec_gym.errors import ConfigurationError
from avsec_gym.evaluation.contested import is_contested
from avsec_gym.scenario.scene_sets import procedural_scenes
from avsec_gym.world.assets import Assets


def test_this_release_makes_the_scenes_of_the_version() -> None:
    for frozen in frozen_sets().values():
        frozen.check()


def test_a_full_entry_has_all_scenes_and_a_quick_one_the_first() -> None:
    for frozen in frozen_sets().values():
        every, first = frozen.layouts(), frozen.layouts(quick=True)
        assert len(every) == len(frozen.numbers) == frozen.full.layouts
        assert [scene.id for scene in first.scenes] == [
            scene.id for scene in every.scenes[: frozen.quick.layouts]
        ]


def test_contested_scenes_are_contested() -> None:
    contested = frozen_sets()["contested"].layouts(quick=True)
    assert contested.intentions is not None
    for scene in contested.labelled:
        assert all(is_contested(scene, way) for way in contested.intentions[scene.id])


def test_other_scenes_are_refused() -> None:
    frozen = frozen_sets()["all"]
    with pytest.raises(ConfigurationError, match="are not those of version 1"):
        replace(frozen, seed=frozen.seed + 5, numbers=(0, 1, 2)).check()


def test_the_digest_knows_millimetres_and_no_rounding_errors() -> None:
    (scene,) = procedural_scenes(1, seed=3).labelled
    boxes = scene.boxes

    def moved(by: float) -> str:
        return digest_of([replace(scene, boxes=replace(boxes, location=boxes.location + by))])

    rounded = np.round(boxes.location, 3)
    exact = replace(scene, boxes=replace(boxes, location=rounded))
    same = replace(scene, boxes=replace(boxes, location=rounded + 1e-9))
    assert digest_of([exact]) == digest_of([same])
    assert moved(0.0) != moved(0.002)
    assert digest_of([scene]) != digest_of([scene, scene])


def test_frames_are_the_scenes_of_the_layouts(few: dict[str, FrozenSet]) -> None:
    contested = few["contested"]
    found = contested.frames()
    (scene,), (layout,) = found.scenes.labelled, contested.layouts().labelled
    assert found.scenes.intentions == {scene.id: contested.intentions[contested.numbers[0]]}
    # What stands beside the view is labelled nowhere; the rest stands where the layout has it.
    distances = np.linalg.norm(scene.boxes.location[:, None] - layout.boxes.location[None], axis=2)
    cars = scene.boxes.category != "DontCare"
    assert cars.any()
    assert (distances[cars].min(axis=1) < 0.02).all()
    assert found.frame(scene).image(2).shape == (120, 320, 3)


def test_frames_are_made_of_judging_assets(few: dict[str, FrozenSet], monkeypatch) -> None:
    asked = {}
    monkeypatch.setattr(
        "avsec_gym.benchmark.scene_sets.chosen_recipe",
        lambda numbers, **given: asked.update(given) or pytest.skip("asked"),
    )
    with pytest.raises(pytest.skip.Exception):
        few["all"].frames()
    assert asked["assets"] == Assets.JUDGE


def test_extents() -> None:
    frozen = replace(frozen_sets()["all"], full=Extent(9, 4), quick=Extent(3, 2))
    counts = [frozen.count(images=i, quick=q) for i in (False, True) for q in (False, True)]
    assert counts == [9, 3, 4, 2]
