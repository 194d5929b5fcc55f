"""Games of a single query on the roads that their scenes lie on."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec
from gymnasium.utils.env_checker import check_env as gymnasium_check_env
from stable_baselines3.common.env_checker import check_env as sb3_check_env

import avsec_gym  # noqa: F401
from avsec_gym.envs.parts import Parts
from avsec_gym.errors import ConfigurationError
from avsec_gym.scenario.own_road import own_road_of
from avsec_gym.world.layouts import layout_by_id

LAYOUTS = ("highway-000002", "street-000003", "highway-000007")
"""Those that the frames are said to be of."""
SENSED = (
    "avsec/DetectorBenchmark-v0",
    "avsec/PerturbationAttack-v0",
    "avsec/PatchAttack-v0",
    "avsec/FaculaAttack-v0",
    "avsec/LidarSpoofing-v0",
)
OBJECT_LEVEL = ("avsec/GhostObject-v1", "avsec/GhostObject-v0")


@pytest.fixture
def procedural(tmp_path: Path, quick: dict[str, Any]) -> dict[str, Any]:
    """The quick frames with scene files, as the procedural world writes them."""
    root = tmp_path / "frames"
    shutil.copytree(quick["scenarios"], root)
    labels = next(root.rglob("label_2"))
    for path, layout in zip(sorted(labels.glob("*.txt")), LAYOUTS, strict=False):
        scene = labels.parent / "scene" / f"{path.stem}.json"
        scene.parent.mkdir(exist_ok=True)
        facts = {"road_type": layout.split("-")[0], "objects": [], "layout": layout}
        scene.write_text(json.dumps(facts))
    return quick | {"scenarios": str(root), "road": "own"}


@pytest.mark.parametrize("id", SENSED)
def test_games_of_sensors_are_played_on_own_roads(id: str, procedural: dict[str, Any]) -> None:
    """By the checkers' rules, with the lanes of the layout before the planner."""
    if id == "avsec/DetectorBenchmark-v0":
        procedural = {name: value for name, value in procedural.items() if name != "detector"}
    spec = EnvSpec.from_json(gym.make(id, **procedural).spec.to_json())  # type: ignore[union-attr]
    env = gym.make(spec)
    if id != "avsec/DetectorBenchmark-v0":  # Random boxes leave no plan, and nan in info.
        gymnasium_check_env(env.unwrapped, skip_render_check=True)
    sb3_check_env(env.unwrapped)
    options = {"scenario": "000000", "intention": "straight"}
    env.reset(seed=0, options=options)
    *_, info = env.step(np.zeros(env.action_space.shape, np.float32))
    assert (info["scenario"], info["intention"]) == ("000000", "straight")


def test_the_planner_gets_the_lanes_of_the_layout_that_the_frame_shows(
    procedural: dict[str, Any],
) -> None:
    _, scenes = Parts(**procedural).car()
    for scene, layout in zip(scenes.scenes.labelled, LAYOUTS, strict=True):
        problem = scene.problem(scene.intentions[0])
        assert problem.road == own_road_of(layout_by_id(layout)).road
        assert len(problem.road.lanelets) < 27


@pytest.mark.parametrize("id", OBJECT_LEVEL)
def test_games_of_detections_are_played_on_own_roads(id: str) -> None:
    scenes = {"name": "layouts", "count": 12}
    env = gym.make(id, scenarios=scenes, road="own", disable_env_checker=True)
    first, info = env.reset(seed=3, options={"scenario": "highway-000007"})
    again, _ = env.reset(seed=3, options={"scenario": "highway-000007"})
    np.testing.assert_array_equal(first, again)
    straight, _ = gym.make(id, scenarios=scenes, disable_env_checker=True).reset(
        seed=3, options={"scenario": "highway-000007", "intention": info["intention"]}
    )
    assert (first[:8] != straight[:8]).any(), "the goal is that of the thesis' lanes"
    *_, info = env.step(env.action_space.sample())
    assert info["outcome"] in {"safe", "collision", "unplanned"}


@pytest.mark.parametrize("batched", [False, True])
def test_only_intentions_with_a_lane_are_drawn(batched: bool) -> None:
    arguments = {"scenarios": {"name": "layouts", "count": 12}, "road": "own"}
    drawn: set[tuple[str, str]] = set()
    if batched:
        many = gym.make_vec("avsec/GhostObject-v0", num_envs=24, **arguments)
        _, infos = many.reset(seed=0)
        drawn |= set(zip(infos["scenario"], infos["intention"], strict=True))
    else:
        env = gym.make("avsec/GhostObject-v0", disable_env_checker=True, **arguments)
        for seed in range(24):
            _, info = env.reset(seed=seed)
            drawn.add((info["scenario"], info["intention"]))
    assert len(drawn) > 5
    for scenario, intention in drawn:
        assert intention in own_road_of(layout_by_id(scenario)).intentions


def test_a_picture_shows_the_own_road() -> None:
    shown = [
        gym.make(
            "avsec/GhostObject-v0",
            scenarios={"name": "layouts", "count": 8},
            road=road,
            render_mode="rgb_array",
            disable_env_checker=True,
        )
        for road in ("thesis", "own")
    ]
    for env in shown:
        env.reset(seed=0, options={"scenario": "street-000003", "intention": "straight"})
    thesis, own = (env.render() for env in shown)
    assert not np.array_equal(thesis, own)


@pytest.mark.parametrize(
    ("id", "given", "complaint"),
    [
        ("avsec/GhostObject-v1", {"road": "onw"}, 'mean "own"'),
        ("avsec/PatchAttack-v0", {"road": "these"}, 'mean "thesis"'),
        ("avsec/ClosedLoop-v0", {"road": "own"}, "takes no 'road': the scenes name it"),
        ("avsec/ClosedLoopAttack-v0", {"road": "own"}, "takes no 'road': the scenes name it"),
        ("avsec/ConnectedSpoofing-v0", {"road": "own"}, "no car drives"),
        ("avsec/SensorIdentification-v0", {"road": "own"}, "no car drives in recordings"),
    ],
)
def test_what_cannot_be_is_refused_at_make(id: str, given: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ConfigurationError, match=complaint):
        gym.make(id, **given)


@pytest.mark.parametrize("id", SENSED)
def test_real_frames_have_no_road_of_their_own(id: str, quick: dict[str, Any]) -> None:
    with pytest.raises(ConfigurationError, match='no road of its own, which road="own" asks for'):
        gym.make(id, scenarios=quick["scenarios"], road="own")


def test_labels_have_no_road_of_their_own(quick: dict[str, Any]) -> None:
    with pytest.raises(ConfigurationError, match="no road of its own"):
        gym.make("avsec/GhostObject-v0", scenarios=quick["scenarios"], road="own")


def test_an_intention_without_a_lane_is_refused(procedural: dict[str, Any]) -> None:
    env = gym.make("avsec/PerturbationAttack-v0", **procedural)
    with pytest.raises(ConfigurationError, match=r"000001: no lane .* intentions here: straight"):
        env.reset(options={"scenario": "000001", "intention": "left"})
