"""`avsec/GhostObject-v0`: its rules; both versions: batches play what single ones play."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from stable_baselines3.common.vec_env import DummyVecEnv

import avsec_gym  # noqa: F401
from avsec_gym.attacks.object_injection import GHOSTS, hide_objects, inject_ghosts
from avsec_gym.boxes import Boxes3D
from avsec_gym.envs.ghost_object import GhostObjectEnv
from avsec_gym.envs.ghost_object_vector import GhostObjectVectorEnv
from avsec_gym.envs.sb3 import StableBaselinesVecEnv
from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import ego_to_camera
from avsec_gym.pipeline import run_episode
from avsec_gym.planners.planner import MotionPrimitivePlanner
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.builder import is_obstacle
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Motion, Scene
from avsec_gym.scenario.scene_set import SceneSet
from avsec_gym.scenario.scene_sets import procedural_scenes, scene_set

ID = "avsec/GhostObject-v0"

RANGE = GHOSTS["car"]


def scene(
    poses: list[list[float]], moving: list[bool] | None = None, id: str = "one", **fields: Any
) -> Scene:
    location, rotation_y = ego_to_camera(np.array(poses, float).reshape(-1, 3), 1.65)
    count = len(rotation_y)
    boxes = Boxes3D(
        location=location,
        dimensions=np.tile([1.5, 1.6, 4.0], (count, 1)),
        rotation_y=rotation_y,
        score=np.ones(count),
        category=np.full(count, "Car"),
        moving=np.array([False] * count if moving is None else moving, bool),
    )
    return Scene(id, boxes, **fields)


def set_of(*scenes: Scene) -> SceneSet:
    return SceneSet("hand-made", scenes)


def action(*ghosts: tuple[float, float, float], size: int = 2, hide: tuple[float, ...] = ()) -> Any:
    """Ghosts at x, y, heading; the others off."""
    rows = np.full((size, 4), -1.0)
    if ghosts:
        rows[: len(ghosts)] = RANGE.encode(np.ones(len(ghosts), bool), np.array(ghosts))
    return np.concatenate([rows.ravel(), hide])


def test_without_a_ghost_nothing_is_won() -> None:
    """The reward cannot be had without changing what the car plans on."""
    env = gym.make(ID, ghost="car")
    for seed in range(40):
        env.reset(seed=seed)
        _, reward, terminated, _, info = env.step(action())
        assert (info["outcome"], terminated, info["is_success"]) == ("safe", False, False)
        assert reward == pytest.approx(-0.02)


def test_ghosts_off_the_road_win_nothing_but_cost() -> None:
    env = gym.make(ID, ghost="car", scenarios=set_of(scene([])))
    env.reset(seed=0, options={"intention": "straight"})
    _, reward, terminated, _, info = env.step(action((28.0, 8.0, 0.0), (29.0, -8.0, 0.0)))
    assert (terminated, info["ghosts"], info["outcome"]) == (False, 2, "safe")
    assert reward == pytest.approx(-0.06)


def test_a_wall_of_ghosts_leaves_no_plan() -> None:
    env = gym.make(ID, ghost="car", scenarios=set_of(scene([])), ghosts=4)
    env.reset(seed=0, options={"intention": "straight"})
    wall = [(9.0, y, np.pi / 2) for y in (-5.7, -1.9, 1.9, 5.7)]
    _, reward, terminated, truncated, info = env.step(action(*wall, size=4))
    assert (info["outcome"], info["is_success"], info["planned"]) == ("unplanned", True, False)
    assert (terminated, truncated) == (True, False)
    assert np.isnan(info["cost"])
    assert reward == pytest.approx(1.0 - 0.02 * 5)


def test_ghosts_in_the_goal_leave_no_plan() -> None:
    env = gym.make(ID, ghost="car", scenarios=set_of(scene([])))
    env.reset(seed=0, options={"intention": "straight"})
    _, _, terminated, _, info = env.step(action((13.0, 0.0, np.pi / 2), (17.0, 0.0, np.pi / 2)))
    assert (info["outcome"], terminated) == ("unplanned", True)


def test_hiding_what_is_in_the_way_makes_a_collision() -> None:
    """A car stands in the lane, ahead of the goal; the planner knows its way around it."""
    blocked = set_of(scene([[13.0, -1.2, 0.0], [24.0, -6.0, 0.0]]))
    env = gym.make(ID, ghost="car", scenarios=blocked, ghosts=1, hides=1)
    env.reset(seed=0, options={"intention": "straight"})
    _, reward, terminated, _, info = env.step(action(size=1, hide=(-1.0,)))
    assert (info["outcome"], info["hidden"]) == ("safe", 0)
    assert reward == pytest.approx(-0.02)
    # 33 equal parts: the second hides the nearest object, the third the other one.
    _, reward, terminated, _, info = env.step(action(size=1, hide=(-1 + 5 / 33,)))
    assert (info["outcome"], info["hidden"], terminated) == ("safe", 1, False)
    assert reward == pytest.approx(-0.04)
    _, reward, terminated, _, info = env.step(action(size=1, hide=(-1 + 3 / 33,)))
    assert (info["outcome"], info["collision"], info["hidden"]) == ("collision", True, 1)
    assert (terminated, info["is_success"]) == (True, True)
    assert reward == pytest.approx(1.0 - 0.04)


def test_hiding_what_is_not_there_is_free() -> None:
    env = gym.make(ID, ghost="car", scenarios=set_of(scene([[13.0, -1.2, 0.0]])), ghosts=0, hides=3)
    env.reset(seed=0, options={"intention": "straight"})
    _, reward, _, _, info = env.step(np.array([1.0, 0.5, -1.0]))
    assert (info["hidden"], info["outcome"]) == (0, "safe")
    assert reward == pytest.approx(-0.02)
    # Twice the same object is one object.
    nearest = -1 + 3 / 33
    info = env.step(np.array([nearest, nearest, -1.0]))[4]
    assert info["hidden"] == 1


def test_the_price_is_an_argument() -> None:
    env = gym.make(ID, ghost="car", scenarios=set_of(scene([])), price=0.1)
    env.reset(seed=0)
    assert env.step(action((29.0, 8.0, 0.0)))[1] == pytest.approx(-0.2)


def test_a_scene_that_is_unsafe_by_itself_gives_no_success() -> None:
    """A reward is for making a safe plan unsafe."""
    wall = [[8.0, y, np.pi / 2] for y in np.arange(-40.0, 41.0, 3.9)]
    scenes = set_of(scene([], id="free"), scene(wall, id="blocked"))
    chosen = {"scenario": "blocked", "intention": "straight"}
    env = gym.make(ID, ghost="car", scenarios=scenes)
    assert {env.reset(seed=seed)[1]["scenario"] for seed in range(20)} == {"free"}
    env.reset(options=chosen)
    _, reward, terminated, _, info = env.step(action())
    assert (info["outcome"], info["is_success"], terminated) == ("unplanned", False, False)
    assert reward == pytest.approx(-0.02)
    many = GhostObjectVectorEnv(2, scenarios=scenes, ghost="car")
    many.reset(seed=0, options=chosen)
    _, rewards, ended, _, infos = many.step(np.stack([action()] * 2))
    assert infos["outcome"].tolist() == ["unplanned"] * 2
    assert not ended.any()
    assert not infos["is_success"].any()
    np.testing.assert_allclose(rewards, -0.02)


def nearest_first(boxes: Boxes3D) -> np.ndarray:
    rows = np.nonzero(is_obstacle(boxes))[0]
    return rows[np.argsort(np.hypot(*boxes.poses[rows, :2].T), kind="stable")]


MOTIONS = (Motion.STATIC, Motion.TRUTH)
"""Of a car that has no classifier."""


def compare_with_pipeline(scenes: SceneSet, motion: Motion, planner: str, seed: int) -> set[str]:
    """Steps of the environment beside `run_episode` on the same attacked boxes."""
    env = GhostObjectEnv(
        scenarios=scenes, planner=planner, ghosts=2, hides=2, motion=motion, ghost="car"
    )
    generator, outcomes = np.random.default_rng(seed), set()
    for scene in scenes.scenes:
        for intention in Intention:
            env.reset(options={"scenario": scene.id, "intention": str(intention)})
            for _ in range(2):
                chosen = generator.uniform(-1, 1, 10)
                chosen[8:] = generator.choice([-1, -1 + 3 / 33, -1 + 5 / 33], 2)
                if generator.random() < 0.3 and len(scene.boxes):
                    # A ghost on top of a real object.
                    onto = scene.boxes.poses[generator.integers(len(scene.boxes))] + 0.3
                    chosen[:4] = np.clip(RANGE.encode(np.ones(1, bool), onto[None])[0], -1, 1)
                info = env.step(chosen)[4]
                on, poses = RANGE.decode(chosen[:8].reshape(2, 4))
                hidden = np.array([i for i in env.game.hidden(chosen[8:]) if i >= 0], int)
                rows = nearest_first(scene.boxes)
                gone = rows[hidden[hidden < len(rows)]]
                believed = inject_ghosts(hide_objects(scene.boxes, gone), poses[on])
                expected = run_episode(
                    scene,
                    intention,
                    believed,
                    motion=motion,
                    planner=MotionPrimitivePlanner(planner),
                ).record
                assert info["outcome"] == expected.outcome, (scene.id, intention)
                np.testing.assert_equal(info["cost"], expected.cost)
                assert info["ghosts"] == on.sum()
                assert info["hidden"] == len(set(gone.tolist()))
                outcomes.add(info["outcome"])
    return outcomes


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("planner", ["astar", "gbfs"])
def test_a_step_is_what_the_pipeline_does(motion: Motion, planner: str) -> None:
    scenes = procedural_scenes(40, seed=3)
    outcomes = compare_with_pipeline(scenes, motion, planner, 1)
    assert outcomes == {"safe", "collision", "unplanned"}


@pytest.mark.parametrize(
    "motion", [MOTIONS[0], *(pytest.param(each, marks=pytest.mark.slow) for each in MOTIONS[1:])]
)
def test_a_step_is_what_the_pipeline_does_on_real_scenes(shared: Path, motion: Motion) -> None:
    every = scene_set(shared / "safety_scenarios")
    moving = [
        scene for scene in every.scenes if scene.boxes.moving is not None and scene.speeds.any()
    ]
    outcomes = compare_with_pipeline(replace(every, scenes=tuple(moving[::2])), motion, "astar", 2)
    assert outcomes == {"safe", "collision", "unplanned"}


def test_a_car_that_comes_after_the_drives_end_is_no_collision() -> None:
    """The plan ends in the goal, 15 m ahead, before the oncoming car is there."""
    late = scene([[36.0, 0.0, np.pi]], [True], number=3)
    for motion in MOTIONS:
        expected = run_episode(late, Intention.STRAIGHT, motion=motion).record
        env = GhostObjectEnv(scenarios=set_of(late), motion=motion)
        env.reset(options={"scenario": "one", "intention": "straight"})
        assert env.step(action())[4]["outcome"] == expected.outcome == "safe"


def test_what_moves_is_the_planners_business() -> None:
    """A car crosses from the right and stands in the goal lane later: only one planner knows."""
    scenes = set_of(scene([[9.0, -8.0, np.pi / 2]], [True], number=1))
    outcomes = {}
    for motion in ("static", "truth"):
        env = GhostObjectEnv(scenarios=scenes, motion=motion)
        env.reset(options={"scenario": "one", "intention": "straight"})
        outcomes[motion] = env.step(action())[4]["outcome"]
    assert outcomes["static"] == "collision"
    assert outcomes["truth"] != "collision"


@pytest.mark.parametrize(
    ("id", "arguments", "without_success"),
    [
        (ID, {"ghost": "car"}, (False, True)),
        (ID, {"ghost": "car", "ghosts": 1, "hides": 2, "motion": "static"}, (False, True)),
        (ID, {"ghost": "car", "queries": 3}, (True, False)),
        ("avsec/GhostObject-v1", {"queries": 4}, (True, True)),
        ("avsec/GhostObject-v1", {"queries": 2, "places": 3, "motion": "truth"}, (True, False)),
    ],
)
def test_the_vector_form_plays_what_single_ones_play(
    id: str, arguments: dict[str, Any], without_success: tuple[bool, bool]
) -> None:
    """At most four steps, whose end without a success is the budget's, the limit's or both's."""
    count, seed = 5, 11
    many = gym.make_vec(
        id, num_envs=count, vectorization_mode="vector_entry_point", max_episode_steps=4,
        **arguments,
    )  # fmt: skip
    singles = [gym.make(id, max_episode_steps=4, **arguments) for _ in range(count)]
    observations, infos = many.reset(seed=seed)
    for i, env in enumerate(singles):
        observation, info = env.reset(seed=seed + i)
        np.testing.assert_array_equal(observations[i], observation)
        same_info(infos, i, info)
    generator, ended, ends = np.random.default_rng(0), [False] * count, set()
    for _ in range(60):
        actions = generator.uniform(-1.2, 1.2, many.action_space.shape).astype(np.float32)
        observations, rewards, terminated, truncated, infos = many.step(actions)
        for i, env in enumerate(singles):
            if ended[i]:  # Autoreset mode NEXT_STEP: this action is not used.
                (observation, info), ended[i] = env.reset(), False
                expected: tuple[float, bool, bool] = (0.0, False, False)
            else:
                observation, *rest, info = env.step(actions[i])
                expected = (rest[0], rest[1], rest[2])
                ended[i] = rest[1] or rest[2]
            np.testing.assert_array_equal(observations[i], observation)
            assert (rewards[i], terminated[i], truncated[i]) == expected
            ends.add(expected[1:])
            same_info(infos, i, info)
    assert {(False, False), (True, False), without_success} <= ends


def same_info(infos: dict[str, Any], i: int, info: dict[str, Any]) -> None:
    assert {name for name in infos if not name.startswith("_")} == set(info)
    for name, value in info.items():
        assert infos[f"_{name}"][i]
        np.testing.assert_equal(infos[name][i], value)


def test_the_vector_form_shares_no_arrays() -> None:
    many = GhostObjectVectorEnv(3)
    one, first = many.reset(seed=0)
    copies = one.copy(), {name: value.copy() for name, value in first.items()}
    two, _, _, _, second = many.step(np.full((3, 8), 0.9, np.float32))
    assert not np.shares_memory(one, two)
    np.testing.assert_array_equal(one, copies[0])
    for name in first:
        np.testing.assert_array_equal(first[name], copies[1][name])
        assert not np.shares_memory(first[name], second[name])


def test_the_vector_form_resets_only_what_a_mask_names() -> None:
    many = GhostObjectVectorEnv(3)
    many.reset(seed=0)
    many.step(np.zeros((3, 8)))
    before = [each.scene.id for each in many._rounds]
    mask = np.array([False, True, False])
    many.reset(seed=[None, 99, None], options={"reset_mask": mask})
    assert many._spent.tolist() == [1, 0, 1]
    after = [each.scene.id for each in many._rounds]
    assert (after[0], after[2]) == (before[0], before[2])
    assert after[1] == gym.make(ID, ghost="car").reset(seed=99)[1]["scenario"]
    assert mask.tolist() == [False, True, False]


def test_the_first_reset_takes_all_and_leaves_the_mask_alone() -> None:
    mask = np.array([False, True])
    many = GhostObjectVectorEnv(2)
    assert many.reset(seed=0, options={"reset_mask": mask})[0].shape[0] == 2
    assert mask.tolist() == [False, True]


def test_wrong_actions_and_arguments_of_the_vector_form() -> None:
    many = GhostObjectVectorEnv(2)
    with pytest.raises(gym.error.ResetNeeded):
        many.step(np.zeros((2, 8)))
    many.reset(seed=0)
    for wrong in (np.zeros(8), np.zeros((3, 8)), np.full((2, 8), np.nan), np.full((2, 8), np.inf)):
        with pytest.raises(ConfigurationError, match="actions have shape"):
            many.step(wrong)
    with pytest.raises(ConfigurationError, match=r"num_envs.*got 0"):
        GhostObjectVectorEnv(0)
    with pytest.raises(ConfigurationError, match="not rendered"):
        GhostObjectVectorEnv(2, render_mode="rgb_array")


def batch(id: str, count: int, **given: Any) -> Any:
    return gym.make_vec(id, num_envs=count, vectorization_mode="vector_entry_point", **given)


def steps_until_the_end(env: gym.Env[Any, Any]) -> tuple[int, bool, bool]:
    env.reset(seed=0)
    for step in range(1, 50):
        observation, _, terminated, truncated, info = env.step(action())
        assert info["queries"] == step
        if terminated or truncated:
            return step, terminated, truncated
        assert env.observation_space.contains(observation)
    raise AssertionError("it never ends")


def test_the_budget() -> None:
    assert steps_until_the_end(GhostObjectEnv()) == (10, True, False)
    assert steps_until_the_end(GhostObjectEnv(queries=30)) == (30, True, False)
    # Gymnasium's time limit counts the last query, too.
    assert steps_until_the_end(gym.make(ID, ghost="car")) == (10, True, True)


@pytest.mark.parametrize(
    ("limits", "end"),
    [
        ({}, (10, True, True)),
        ({"queries": 3}, (3, True, False)),
        ({"max_episode_steps": 4}, (4, False, True)),
        ({"max_episode_steps": 13}, (10, True, False)),
        ({"max_episode_steps": 13, "queries": 12}, (12, True, False)),
        ({"max_episode_steps": 12, "queries": 12}, (12, True, True)),
        ({"max_episode_steps": -1, "queries": 20}, (20, True, False)),
        ({"max_episode_steps": -1}, (10, True, False)),
    ],
    ids=str,
)
def test_the_vector_form_has_the_same_budget(
    limits: dict[str, int], end: tuple[int, bool, bool]
) -> None:
    many = batch(ID, 1, ghost="car", **limits)
    single = gym.make(ID, ghost="car", **limits)
    assert steps_until_the_end(single) == end
    many.reset(seed=0), single.reset(seed=0)
    for step in range(1, end[0] + 1):
        observations, _, *over, _ = many.step(action()[None])
        observation, _, *ends, _ = single.step(action())
        np.testing.assert_array_equal(observations[0], observation)
        assert [each[0] for each in over] == ends
        assert tuple(ends) == (end[1:] if step == end[0] else (False, False))


@pytest.mark.parametrize("limits", [{}, {"max_episode_steps": 4}, {"max_episode_steps": -1}])
def test_a_success_at_the_last_query_ends_as_in_single_ones(limits: dict[str, int]) -> None:
    """It is paid as a success, and terminated once."""
    wall = action(*[(9.0, y, np.pi / 2) for y in (-5.7, -1.9, 1.9, 5.7)], size=4)
    given = {"ghost": "car", "ghosts": 4, "queries": 4, "scenarios": set_of(scene([])), **limits}
    many, single = batch(ID, 1, **given), gym.make(ID, **given)
    for each in (many, single):
        each.reset(seed=0, options={"intention": "straight"})
    for step in range(1, 5):
        asked = wall if step == 4 else action(size=4)
        _, (reward,), *over, infos = many.step(asked[None])
        _, paid, *ends, info = single.step(asked)
        assert [each[0] for each in over] == ends
        assert reward == pytest.approx(paid)
        assert infos["is_success"][0] == info["is_success"] == (step == 4)
    assert ends == [True, limits.get("max_episode_steps") == 4]
    assert paid == pytest.approx(1.0 - 0.02 * 5)


def test_a_budget_that_gymnasium_would_cut_is_refused_of_many_with_the_remedy() -> None:
    for id, limits in ((ID, {"queries": 11}), (ID, {"queries": 5, "max_episode_steps": 4}),
                       ("avsec/GhostObject-v1", {"queries": 2})):  # fmt: skip
        remedy = f"max_episode_steps={limits['queries']} as well, or -1"
        with pytest.raises(ConfigurationError, match=remedy):
            batch(id, 2, **limits)


def test_a_failure_is_worth_nothing_more_to_stable_baselines3() -> None:
    """It adds the value of what follows where a time limit alone ends an episode."""
    for limits, cut in (({}, False), ({"max_episode_steps": 4}, True)):
        given = {"ghost": "car", **limits}
        one = DummyVecEnv([lambda given=given: gym.make(ID, **given)])
        for many in (StableBaselinesVecEnv(batch(ID, 1, **given)), one):
            many.reset()
            for _ in range(4 if cut else 10):
                _, _, ended, infos = many.step(action()[None])
            assert ended[0]
            assert infos[0]["TimeLimit.truncated"] == cut


def test_options_reach_every_environment_of_a_batch() -> None:
    many = StableBaselinesVecEnv(batch(ID, 3, ghost="car"))
    picked = gym.make(ID, ghost="car").reset(seed=0)[1]["scenario"]
    many.seed(1)
    many.set_options({"scenario": picked, "intention": "straight"})
    many.reset()
    infos = many.step(np.zeros((3, 8)))[-1]
    assert {(info["scenario"], info["intention"]) for info in infos} == {(picked, "straight")}
    # They hold for one reset, as in stable-baselines3's own.
    many.reset()
    assert {info["scenario"] for info in many.step(np.zeros((3, 8)))[-1]} != {picked}
    many.set_options([{"intention": "left"}, {"intention": "right"}, {}])
    with pytest.raises(ConfigurationError, match="give set_options one dictionary"):
        many.reset()


def test_the_share_of_queries_left_is_observed_and_stays_in_the_space() -> None:
    env = GhostObjectEnv(queries=4)
    observation, _ = env.reset(seed=0)
    shares = [observation[8 + 32 * 8 + 4]]
    for _ in range(12):  # Also of an agent that does not stop.
        observation, *_ = env.step(action())
        assert env.observation_space.contains(observation)
        shares.append(observation[8 + 32 * 8 + 4])
    assert shares == [1.0, 0.75, 0.5, 0.25] + [0.0] * 9


def test_what_the_observation_tells() -> None:
    one = scene([[20.0, -5.0, 0.5], [10.0, 4.0, 0.0]], [True, False], road_type=RoadType.HIGHWAY)
    env = gym.make(ID, ghost="car", scenarios=set_of(one), hides=1)
    observation, _ = env.reset(seed=0, options={"scenario": "one", "intention": "right"})
    np.testing.assert_allclose(
        observation[:8], [11 / 15, 1, 0, 0, 1, 15 / 50, -3.5 / 20, 2 / 32], atol=1e-6
    )
    objects = observation[8:264].reshape(32, 8)
    near = [1, 10 / 50, 4 / 20, 1, 0, 0.4, 0.4, 0]
    far = [1, 20 / 50, -5 / 20, np.cos(0.5), np.sin(0.5), 0.4, 0.4, 1]
    np.testing.assert_allclose(objects[:2], [near, far], atol=1e-6)
    assert not objects[2:].any()
    last = observation[264:]
    np.testing.assert_allclose(last[:5], [0, 0, 0, 0, 1])
    asked = action((17.5, 4.0, np.pi / 2), size=2, hide=(-0.9,))
    observation, _, _, _, info = env.step(asked)
    last = observation[264:]
    word = ["safe", "collision", "unplanned"].index(info["outcome"])
    assert last[:3].tolist() == [float(word == i) for i in range(3)]
    assert last[3] == pytest.approx(0 if np.isnan(info["cost"]) else info["cost"] / 3)
    np.testing.assert_allclose(last[5:10], [1, 0, 0.5, 0, 1], atol=1e-6)
    assert last[10] == 0
    assert last[15] == pytest.approx(-0.9)


def test_more_objects_than_the_observation_holds() -> None:
    """All of them are planned around and judged; the 32 nearest are observed."""
    crowd = [[9.0, y, 0.0] for y in np.arange(-60.0, 61.0, 2.0)]
    crowded = set_of(scene([[100.0 + i, 30.0, 0.0] for i in range(40)]), scene(crowd, id="wall"))
    env = GhostObjectEnv(scenarios=crowded)
    observation, _ = env.reset(options={"scenario": "wall", "intention": "straight"})
    assert env.observation_space.contains(observation)
    assert observation[8:264].reshape(32, 8)[:, 0].all()
    assert env.step(action())[4]["outcome"] == "unplanned"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"ghosts": 0}, "places ghosts or hides"),
        ({"ghosts": -1, "hides": 3}, "from 0 to 32, got -1"),
        ({"scenarios": "layuots"}, 'Did you mean "layouts"'),
        ({"scenarios": {"name": "layouts", "colour": 1}}, "colour"),
        ({"scenarios": {"count": 3}}, "name"),
        ({"scenarios": {"name": "layouts", "count": 0}}, "from 1 to 100,000, got 0"),
        ({"scenarios": {"name": "layouts", "seed": -1}}, "0 or more"),
        ({"scenarios": SceneSet("nothing", ())}, "empty"),
        ({"scenarios": None}, "a name or a folder, got None"),
        ({"scenarios": 5}, "a name or a folder, got 5"),
        ({"planner": "dijkstra"}, "astar"),
        ({"planner": {"name": "astar", "mode": "reference"}}, "complete mode"),
        ({"planner": object()}, "a planner is"),
        ({"motion": "guessed"}, "static.*truth"),
        ({"motion": "classifier"}, 'use "static" or "truth"'),
        ({"queries": 0}, "1 or more"),
        ({"queries": -3}, "1 or more"),
    ],
)
@pytest.mark.parametrize("form", [GhostObjectEnv, GhostObjectVectorEnv])
def test_wrong_arguments_are_refused(form: Any, arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigurationError, match=message):
        form(**arguments)


def test_a_set_without_a_safe_drive_is_refused() -> None:
    wall = [[8.0, y, np.pi / 2] for y in np.arange(-40.0, 41.0, 3.9)]
    with pytest.raises(ConfigurationError, match="nothing to attack"):
        GhostObjectEnv(scenarios=set_of(scene(wall))).reset(seed=0)


def test_folders_and_live_parts_are_taken(tmp_path: Path) -> None:
    label = "Car 0.00 0 0.00 1.00 1.00 9.00 9.00 1.50 1.60 4.00 -4.00 1.65 10.00 -1.57\n"
    (tmp_path / "000007.txt").write_text(label)
    for scenarios in (tmp_path, str(tmp_path), {"name": str(tmp_path)}, scene_set(tmp_path)):
        env = GhostObjectEnv(scenarios=scenarios, planner=MotionPrimitivePlanner("gbfs"))
        assert env.reset(seed=0)[1]["scenario"] == "000007"


def test_drawn_start_speeds_are_planned_with() -> None:
    """Scenes of one road type and intention may differ in their start speed."""
    scenes = set_of(
        *(scene([[20.0, 6.0, 0.0]], id=str(i), number=i, draw_start_speed=True) for i in range(3))
    )
    many = GhostObjectVectorEnv(3, scenarios=scenes)
    costs = []
    for drawn in scenes.scenes:
        expected = run_episode(drawn, Intention.STRAIGHT).record.cost
        _, _ = many.reset(seed=0, options={"scenario": drawn.id, "intention": "straight"})
        np.testing.assert_allclose(many.step(np.stack([action()] * 3))[4]["cost"], expected)
        costs.append(expected)
    mixed = many.game.play(
        [many.game.round(i, Intention.STRAIGHT) for i in range(3)], np.stack([action()] * 3)
    )[1]
    np.testing.assert_allclose(mixed, costs)


def test_patch_ghosts_are_small_and_far() -> None:
    env = gym.make(ID, scenarios=set_of(scene([])))
    env.reset(seed=0, options={"intention": "straight"})
    rows = GHOSTS["patch"].encode(np.ones(2, bool), np.array([[10.0, 0.9, 0.0], [15.0, -0.9, 0.0]]))
    _, _, _, _, info = env.step(rows.ravel())
    believed = inject_ghosts(
        Boxes3D.empty(), [[10.0, 0.9, 0.0], [15.0, -0.9, 0.0]], GHOSTS["patch"].dimensions
    )
    one = scene([])
    expected = run_episode(one, Intention.STRAIGHT, believed, motion=Motion.STATIC)
    assert info["outcome"] == expected.record.outcome


def test_a_pair_of_ghosts_for_each_intention_wins_everywhere() -> None:
    """What v1 is for: nothing of the scene is looked at."""
    envs = gym.make_vec(ID, num_envs=100)
    observations, _ = envs.reset(seed=0)
    pairs = np.full((100, 2, 4), [1.0, -1.0, 0.0, 0.0], np.float32)
    sides = np.array([[-0.1, 0.2], [-0.3, 0.1], [-0.5, -0.1]])
    pairs[:, :, 2] = sides[observations[:, 2:5].argmax(axis=1)]
    assert envs.step(pairs.reshape(100, 8))[2].mean() > 0.95
