"""The vector form of `avsec/ClosedLoop-v0` drives what highway-env drives, step for step."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import avsec_gym  # noqa: F401
from avsec_gym.closed_loop.error_model.model import ErrorModel, Ghosts, Spread
from avsec_gym.closed_loop.loop_scenes import LoopScenes
from avsec_gym.closed_loop.perception import TruthPerception
from avsec_gym.closed_loop.tracks import STEP, Tracks
from avsec_gym.closed_loop.traffic_scene import TrafficScene
from avsec_gym.envs.closed_loop_vector import ClosedLoopVectorEnv
from avsec_gym.envs.planner_driver import PlannerDriver, PlannerDrivers
from avsec_gym.envs.sb3 import StableBaselinesVecEnv
from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats
from avsec_gym.planners.vehicle import BMW_320I
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.planning_scenario import EgoState
from avsec_gym.scenario.road import Lanelet, Road

ID = "avsec/ClosedLoop-v0"
MODEL = ErrorModel(
    found=(4.0, -1.0, -0.3, -3.0, -3.0, -1.0),
    spreads={
        "radial": Spread(0.1, 0.3, 0.6, 4.0),
        "lateral": Spread(0.0, 0.1, 0.4, 5.0),
        "turn": Spread(0.0, 0.05, 0.2, 3.0),
        "log_length": Spread(0.0, 0.06, 0.0, 6.0),
        "log_width": Spread(0.0, 0.04, 0.0, 6.0),
    },
    turned_round=0.05,
    ghosts=Ghosts(0.5, ((20.0, -2.0, 0.1, 1.5, 1.6, 4.0), (12.0, 3.0, 3.0, 1.4, 1.7, 4.2)), 0.3),
)
ERRORS = {"name": "error_model", "model": MODEL}


def bend(along: Floats, left: float) -> tuple[tuple[float, float], ...]:
    """Points to the left of a road that runs straight for 30 m, then bends with 60 m radius."""
    turned = np.maximum(along - 30.0, 0.0) / 60.0
    x = np.minimum(along, 30.0) + 60.0 * np.sin(turned) - left * np.sin(turned)
    y = 60.0 * (1.0 - np.cos(turned)) + left * np.cos(turned)
    return tuple(zip(x.tolist(), y.tolist(), strict=True))


def bent_scene(id: str) -> TrafficScene:
    """Two lanes of two lanelets each; a parked car, an oncoming one, a person who comes and goes.

    The car touches a box from the start on.
    """
    spans = [np.arange(-20.0, 41.0, 4.0), np.arange(40.0, 131.0, 3.0)]
    lanelets = []
    for lane, offset in enumerate((0.0, 3.4)):
        for part, span in enumerate(spans):
            number = 1 + 2 * lane + part
            lanelets.append(
                Lanelet(
                    id=number,
                    left=bend(span, offset + 1.7),
                    right=bend(span, offset - 1.7),
                    successors=() if part else (number + 1,),
                    adjacent_left=None if lane else (number + 2, True),
                    adjacent_right=(number - 2, True) if lane else None,
                )
            )
    count, steps = 4, 120
    time = STEP * np.arange(steps)
    poses, speeds = np.zeros((count, steps, 3)), np.zeros((count, steps))
    poses[0] = 24.0, -1.2, 0.1
    poses[1] = np.column_stack([60.0 - 6.0 * time, 0.0 * time + 4.6, 0.0 * time + math.pi])
    speeds[1] = 6.0
    poses[2] = np.column_stack([0.0 * time + 35.0, 1.3 * time - 4.0, 0.0 * time + 1.5])
    speeds[2] = 1.3
    poses[3] = -2.4, 0.3, 0.4
    return TrafficScene(
        id=id,
        road=Road(tuple(lanelets)),
        road_type=RoadType.STREET,
        start=EgoState(0.0, 0.0, 6.5, 0.02, steering_angle=0.01),
        tracks=Tracks(
            ids=np.array([7, 3, 12, 5]),
            categories=np.array(["Car", "Van", "Pedestrian", "Misc"]),
            dimensions=np.array([[1.5, 1.8, 4.2], [2, 2, 5], [1.7, 0.6, 0.5], [1, 0.8, 0.9]]),
            poses=poses,
            speeds=speeds,
            first=np.array([0, 2, 9, 0]),
            last=np.array([119, 61, 43, 119]),
            below=np.full(4, 1.65),
        ),
        cruise=(6.0, 8.0),
        sets_off=0.13,
    )


BENT = LoopScenes(("bent", "bent again"), bent_scene)


def touching_scene(id: str) -> TrafficScene:
    """Boxes that graze the car on both sides at the start, and a van that its bumper touches.

    The van drives off, faster than the car, and stands in its lane after 18 m.
    """
    scene, steps = bent_scene(id), 120
    poses, speeds = np.zeros((3, steps, 3)), np.zeros((3, steps))
    poses[0], poses[1] = (-1.5, 0.9, 0.0), (-1.5, -0.9, 0.0)
    way = np.minimum(9.0 * STEP * np.arange(steps), 18.0)
    poses[2] = np.column_stack([4.7 + way, 0.0 * way, 0.0 * way])
    speeds[2, :20] = 9.0
    tracks = Tracks(
        ids=np.array([4, 9, 2]),
        categories=np.array(["Misc", "Misc", "Van"]),
        dimensions=np.array([[1.0, 0.8, 0.9], [1.0, 0.8, 0.9], [2.0, 2.0, 5.0]]),
        poses=poses,
        speeds=speeds,
        first=np.zeros(3, int),
        last=np.full(3, steps - 1),
        below=np.full(3, 1.65),
    )
    return replace(scene, tracks=tracks)


SOURCES = {
    "layouts": {"source": "layouts", "count": 12},
    "drives": {"source": "drives", "count": 3},
    "bent": BENT,
}


def same_info(infos: dict[str, Any], i: int, info: dict[str, Any]) -> None:
    assert {name for name in infos if not name.startswith("_")} == set(info)
    for name, value in info.items():
        assert infos[f"_{name}"][i]
        got = infos[name][i]
        if isinstance(value, float):
            assert got == pytest.approx(value, rel=1e-6, abs=1e-6, nan_ok=True), name
        else:
            assert type(value)(got) == value, name


@pytest.mark.parametrize(
    ("source", "arguments", "steps"),
    [
        ("layouts", {}, 1000),
        ("layouts", {"perception": ERRORS}, 250),
        ("layouts", {"motion": "static", "duration": 1.25}, 60),
        ("bent", {}, 300),
        ("bent", {"perception": ERRORS}, 250),
        ("bent", {"perception": ERRORS, "motion": "static"}, 60),
        ("bent", {"perception": "blind"}, 60),
        pytest.param("drives", {}, 300, marks=pytest.mark.slow),
        pytest.param("drives", {"perception": ERRORS}, 250, marks=pytest.mark.slow),
    ],
)
def test_it_drives_what_single_ones_drive(
    source: str, arguments: dict[str, Any], steps: int
) -> None:
    """Steps of all drives together; highway-env's objects on one side, arrays on the other."""
    count, seed = 4, 11
    given = {"scenarios": SOURCES[source], **arguments}
    many = gym.make_vec(ID, num_envs=count, vectorization_mode="vector_entry_point", **given)
    singles = [gym.make(ID, disable_env_checker=True, **given) for _ in range(count)]
    observations, infos = many.reset(seed=seed)
    for i, env in enumerate(singles):
        observation, info = env.reset(seed=seed + i)
        np.testing.assert_allclose(observations[i], observation, atol=1e-6)
        same_info(infos, i, info)
    generator, ended, outcomes = np.random.default_rng(0), [False] * count, set()
    # Each keeps a habit for a while: pure noise would drive straight on, on average.
    habits = generator.uniform(-1, 1, (steps, count, 2)) * (1.0, 0.12)
    for step in range(-(-steps // count)):
        noise = generator.normal(size=(count, 2)) * (0.5, 0.1)
        actions = (habits[step // 25] + noise).astype(np.float32)
        observations, rewards, terminated, truncated, infos = many.step(actions)
        for i, env in enumerate(singles):
            if ended[i]:  # Autoreset mode NEXT_STEP: this action is not used.
                observation, info = env.reset()
                expected: tuple[float, bool, bool] = (0.0, False, False)
            else:
                observation, *expected, info = env.step(actions[i])  # type: ignore[assignment]
            ended[i] = expected[1] or expected[2]
            np.testing.assert_allclose(observations[i], observation, atol=1e-6)
            assert rewards[i] == pytest.approx(expected[0], abs=1e-9)
            assert (terminated[i], truncated[i]) == tuple(expected[1:])
            outcomes.add(info["outcome"])
            same_info(infos, i, info)
    assert {"driving", "reset"} < outcomes


def test_what_touches_at_the_start_is_excused_until_the_touch_ends() -> None:
    """Both boxes are, not one alone; the van is no more when the car rams it."""
    given: dict[str, Any] = {"scenarios": LoopScenes(("touching",), touching_scene)}
    many = ClosedLoopVectorEnv(1, **given)
    single = gym.make(ID, disable_env_checker=True, **given)
    many.reset(seed=0)
    single.reset(seed=0)
    for _ in range(80):
        observations, _, terminated, _, infos = many.step(np.zeros((1, 2), np.float32))
        observation, _, ended, _, info = single.step(np.zeros(2, np.float32))
        np.testing.assert_allclose(observations[0], observation, atol=1e-6)
        same_info(infos, 0, info)
        assert terminated[0] == ended
        if ended:
            break
    assert info["outcome"] == "collision"
    assert info["at_fault"] == 1.0
    gap = 4.7 + 18.0 - 2.5 - BMW_320I.length / 2
    assert many.alone[0].elapsed == pytest.approx(0.05 * math.ceil(gap / 6.5 / 0.05))


def test_same_seed_same_drives() -> None:
    def played() -> list[Any]:
        many = ClosedLoopVectorEnv(3, perception=ERRORS, scenarios=BENT)
        rows: list[Any] = [many.reset(seed=5)[0]]
        many.action_space.seed(0)
        for _ in range(40):
            rows.append(many.step(0.5 * many.action_space.sample())[0])
        return rows

    np.testing.assert_array_equal(played(), played())


def test_it_shares_no_arrays() -> None:
    many = ClosedLoopVectorEnv(2, scenarios=BENT)
    one, first = many.reset(seed=0)
    copies = one.copy(), {name: value.copy() for name, value in first.items()}
    two, _, _, _, second = many.step(np.full((2, 2), 0.2, np.float32))
    assert not np.shares_memory(one, two)
    np.testing.assert_array_equal(one, copies[0])
    for name in first:
        np.testing.assert_array_equal(first[name], copies[1][name])
        assert not np.shares_memory(first[name], second[name])


def test_it_resets_only_what_a_mask_names() -> None:
    many = ClosedLoopVectorEnv(3, scenarios=SOURCES["layouts"])
    many.reset(seed=0)
    many.step(np.zeros((3, 2)))
    before = [alone.drive for alone in many.alone]
    mask = np.array([False, True, False])
    _, info = many.reset(seed=[None, 99, None], options={"reset_mask": mask})
    assert [alone.elapsed for alone in many.alone] == [0.1, 0.0, 0.1]
    assert many.alone[0].drive is before[0]
    single = gym.make(ID, scenarios=SOURCES["layouts"]).reset(seed=99)[1]
    assert (info["scenario"][1], info["intention"][1]) == (single["scenario"], single["intention"])


def test_a_scene_and_an_intention_can_be_picked() -> None:
    many = ClosedLoopVectorEnv(2, scenarios=BENT)
    _, info = many.reset(options={"scenario": "bent again", "intention": "left"})
    assert info["scenario"].tolist() == ["bent again"] * 2
    assert info["intention"].tolist() == ["left"] * 2
    with pytest.raises(ConfigurationError, match="right"):
        many.reset(options={"scenario": "bent", "intention": "right"})


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"traffic": "reacting"}, "recorded traffic.*sync"),
        ({"traffic": {"name": "reacting", "share": 0.5}}, "recorded traffic.*sync"),
        ({"observation": "frame"}, "no frames.*sync"),
        ({"frame_size": (24, 80)}, "no frames.*sync"),
        ({"config": {"policy_frequency": 5}}, "config.*sync"),
        ({"render_mode": "rgb_array"}, "not rendered.*sync"),
        ({"perception": "sensors"}, "error model.*sync"),
        ({"perception": type("Mine", (TruthPerception,), {})()}, "error model.*sync"),
        ({"perception": ERRORS, "motion": "classifier", "classifier": "small"}, "classifier"),
        ({"num_envs": 0}, "num_envs"),
    ],
)
def test_what_only_a_single_environment_has_is_refused(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigurationError, match=message):
        ClosedLoopVectorEnv(**{"num_envs": 2, "scenarios": BENT, **wrong})


def test_wrong_actions_are_refused() -> None:
    many = ClosedLoopVectorEnv(2, scenarios=BENT)
    with pytest.raises(gym.error.ResetNeeded):
        many.step(np.zeros((2, 2)))
    many.reset(seed=0)
    for wrong in (np.zeros(2), np.zeros((3, 2)), np.full((2, 2), np.nan)):
        with pytest.raises(ConfigurationError, match="actions have shape"):
            many.step(wrong)


@pytest.mark.parametrize("arguments", [{}, {"perception": ERRORS}])
def test_planners_drive_many_cars_as_they_drive_one(arguments: dict[str, Any]) -> None:
    given = {"scenarios": SOURCES["layouts"], **arguments}
    many = ClosedLoopVectorEnv(2, **given)
    singles = [gym.make(ID, disable_env_checker=True, **given) for _ in range(2)]
    drivers, alone = PlannerDrivers(many), [PlannerDriver(env) for env in singles]
    many.reset(seed=3)
    for i, env in enumerate(singles):
        env.reset(seed=3 + i)
    ended = np.zeros(2, bool)
    for _ in range(90):
        actions, _ = drivers.predict(np.zeros((2, 0), np.float32))
        _, _, terminated, truncated, info = many.step(actions)
        for i in np.flatnonzero(~ended).tolist():
            action, _ = alone[i].predict(np.zeros(0, np.float32))
            np.testing.assert_allclose(actions[i], action, atol=1e-5)
            result = singles[i].step(action)
            assert info["outcome"][i] == result[-1]["outcome"]
        ended |= terminated | truncated
        if ended.all():
            break
    assert ended.all()


def test_one_planner_for_one_many_for_many() -> None:
    with pytest.raises(ConfigurationError, match="vector form"):
        PlannerDrivers(gym.make(ID))


def test_stable_baselines3_takes_it() -> None:
    many = StableBaselinesVecEnv(gym.make_vec(ID, num_envs=3, scenarios=BENT))
    many.reset()
    ends = 0
    for _ in range(60):
        _, _, ended, infos = many.step(np.tile([0.3, 0.4], (3, 1)).astype(np.float32))
        for info, over in zip(infos, ended, strict=True):
            assert ("terminal_observation" in info) == over
        ends += int(ended.sum())
    assert ends > 0
