"""The chosen scenarios are contested streets, each once, and always the same ones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.evaluation.contested import is_contested
from avsec_gym.geometry import ego_to_camera
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Scene
from avsec_gym.scenario.scene_set import SceneSet
from studies.chapter5.contested_twins import chosen


def scene(id: str, *pose: float) -> Scene:
    location, rotation_y = ego_to_camera(np.array([pose]), 1.65)
    size, category = np.array([[1.5, 1.6, 4.0]]), np.array(["Car"])
    return Scene(id, Boxes3D(location, size, rotation_y, np.ones(1), category))


def test_contested_streets_are_chosen_by_chance() -> None:
    contested = [scene(f"left{number}", 13.0, 3.5, 0.0) for number in range(6)]
    highway = replace(scene("highway", 13.5, 4.4, 0.0), road_type=RoadType.HIGHWAY)
    assert is_contested(highway, Intention.LEFT)
    others = [scene("far", 40.0, 0.0, 0.0), highway]
    every = SceneSet("made", (*others, *contested))
    found = chosen(every, 3)
    assert 2 <= len(set(found)) == len(found) <= 3
    assert set(found) <= {each.id for each in contested}
    assert found == sorted(found) == chosen(every, 3)
    assert len({tuple(chosen(every, 3, seed)) for seed in range(10)}) > 1
    # The highway counts among those that are drawn, and is left out.
    assert chosen(every, 7) == [each.id for each in contested]
    with pytest.raises(ConfigurationError, match="7 scenarios are contested, not 8"):
        chosen(every, 8)
