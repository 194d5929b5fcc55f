"""The planner as a driver."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import avsec_gym  # noqa: F401 - registers the environments
from avsec_gym.boxes import Boxes3D
from avsec_gym.closed_loop import planner_policy
from avsec_gym.closed_loop.belief import Belief
from avsec_gym.closed_loop.fail_safe import is_fail_safe
from avsec_gym.closed_loop.planner_policy import Ambition, PlannerPolicy, Replanning
from avsec_gym.closed_loop.tracks import Tracks
from avsec_gym.closed_loop.traffic_scene import TrafficScene, thesis_road
from avsec_gym.envs.planner_driver import PlannerDriver
from avsec_gym.pipeline import Pipeline, run_episode
from avsec_gym.planners.planner import MotionPrimitivePlanner
from avsec_gym.planners.vehicle import BMW_320I
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.builder import GOAL_STEPS
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.planning_scenario import EgoState
from avsec_gym.scenario.scene import Motion
from avsec_gym.scenario.scene_set import SceneSet
from avsec_gym.scenario.scene_sets import procedural_scenes, scene_set


def driven(env: gym.Env[Any, Any], driver: PlannerDriver, **options: Any) -> dict[str, Any]:
    """The last info of a drive by a planner."""
    observation, info = env.reset(seed=0, options=options or None)
    ended = False
    while not ended:
        observation, _, terminated, truncated, info = env.step(driver.predict(observation)[0])
        ended = terminated or truncated
    return info


@pytest.mark.parametrize("planner", ["astar", "gbfs"])
def test_the_first_plan_is_that_of_the_single_query(planner: str) -> None:
    """Under truth, state by state; it is driven where it is fail-safe."""
    count = 12
    env = gym.make(
        "avsec/ClosedLoop-v0",
        scenarios={"source": "layouts", "count": count, "people": False},
        planner=planner,
    )
    driver = PlannerDriver(env)
    compared = 0
    for scene in procedural_scenes(count).labelled:
        for intention in Intention:
            observation, _ = env.reset(
                seed=0, options={"scenario": scene.id, "intention": str(intention)}
            )
            driver.predict(observation)
            decision = driver.policy.decisions[0]
            chain = Pipeline("oracle", planner=planner, motion=Motion.TRUTH)
            single = run_episode(scene, intention, motion=chain.motion, planner=chain.planner)
            expected = single.plan.trajectory
            if expected is None:  # The car then has a lesser aim.
                assert decision.single is None
                assert decision.ambition != Ambition.CHANGE
                continue
            assert decision.single is not None
            found = decision.single.trajectory
            np.testing.assert_allclose(found, expected, atol=1e-6)  # type: ignore[arg-type]
            if decision.ambition == Ambition.CHANGE:
                compared += 1
                assert decision.plan is decision.single
    assert compared > 20


def test_a_plan_is_driven_as_it_was_planned() -> None:
    env = gym.make("avsec/ClosedLoop-v0", scenarios={"source": "layouts", "count": 3})
    driver = PlannerDriver(env)
    observation, _ = env.reset(seed=1)
    for _ in range(5):
        observation, *_ = env.step(driver.predict(observation)[0])
    played: Any = env.unwrapped
    plan = driver.policy.decisions[0].plan.trajectory
    assert plan is not None
    state = played.state
    reached = (state.x, state.y, state.velocity, state.heading, state.steering_angle)
    np.testing.assert_allclose(reached, plan[5], atol=1e-3)


def test_where_the_way_is_blocked_the_car_stops_before_it() -> None:
    """A wall of lorries across all lanes, 25 m ahead."""
    (scene,) = procedural_scenes(1).labelled
    across = np.arange(-47.0, 48.0, 2.6)
    wall = Boxes3D(
        location=np.column_stack([across, np.full(len(across), 1.65), np.full(len(across), 25.0)]),
        dimensions=np.tile([3.0, 2.5, 6.0], (len(across), 1)),
        rotation_y=np.full(len(across), -np.pi / 2),
        score=np.ones(len(across)),
        category=np.full(len(across), "Truck"),
        moving=np.zeros(len(across), bool),
    )
    scenes = SceneSet("wall", (replace(scene, boxes=wall),))
    env = gym.make("avsec/ClosedLoop-v0", scenarios=scenes)
    info = driven(env, PlannerDriver(env))
    assert info["outcome"] == "stopped"
    assert 0.0 < info["smallest_distance"] < 15.0


def test_with_truth_no_scene_ends_in_a_collision_of_the_cars_fault() -> None:
    env = gym.make("avsec/ClosedLoop-v0", scenarios={"source": "layouts", "count": 12})
    driver = PlannerDriver(env)
    outcomes = []
    for number in range(12):
        info = driven(env, driver, scenario=env.unwrapped.scenes.ids[number])  # type: ignore[attr-defined]
        outcomes.append(info["outcome"])
        assert info["at_fault"] == 0.0, info
    assert outcomes.count("goal") >= 8


@pytest.mark.slow
def test_a_blind_car_collides_where_a_seeing_one_does_not() -> None:
    """The belief is what is planned on, the truth what is touched."""
    outcomes = {}
    for level in ("truth", "blind"):
        scenarios = {"source": "layouts", "count": 12}
        env = gym.make("avsec/ClosedLoop-v0", scenarios=scenarios, perception=level)
        driver = PlannerDriver(env)
        ids = env.unwrapped.scenes.ids  # type: ignore[attr-defined]
        outcomes[level] = [driven(env, driver, scenario=id)["collision"] for id in ids]
    assert sum(outcomes["blind"]) > sum(outcomes["truth"])


def test_in_a_bend_the_car_does_not_swing_out_of_the_way_of_what_keeps_to_its_own_lane() -> None:
    """Oncoming cars were believed to cross the car's lane: it left that, and met one there."""
    env = gym.make("avsec/ClosedLoop-v0", scenarios={"source": "drives", "count": 300})
    driver = PlannerDriver(env)
    info = driven(env, driver, scenario="drive-000123")
    assert info["outcome"] == "goal"
    assert all(each.ambition != Ambition.STOP for each in driver.policy.decisions)


def test_the_car_does_not_come_to_rest_over_the_centre_line_before_an_oncoming_one() -> None:
    env = gym.make("avsec/ClosedLoop-v0", scenarios={"source": "drives", "count": 300})
    assert driven(env, PlannerDriver(env), scenario="drive-000150")["outcome"] == "goal"


def decided(speed: float, poses: Any, speeds: Any) -> tuple[Replanning, Belief]:
    """The first decision of a car that drives at a speed and believes in cars of 4 x 2 m."""
    nothing = np.zeros(0)
    empty = Tracks.at_constant_velocity(
        np.array([], str), np.zeros((0, 3)), np.zeros((0, 3)), nothing, nothing, 2
    )
    start = EgoState(velocity=speed)
    cruise = speed - 1.0, speed + 1.0
    scene = TrafficScene("road", thesis_road(), RoadType.HIGHWAY, start, empty, cruise)
    count = len(poses)
    sizes = np.full(count, 4.0), np.full(count, 2.0)
    belief = Belief(0.0, np.array(poses), *sizes, np.array(speeds), RoadType.HIGHWAY)
    policy = PlannerPolicy()
    policy.begin(scene, Intention.STRAIGHT)
    policy.drive(start, belief)
    return policy.decisions[0], belief


def test_at_high_speed_a_plan_is_fail_safe_until_the_car_stands() -> None:
    """What comes in the own lane was believed to stand after 3 s, and the car drove on."""
    decision, belief = decided(20.0, [(100.0, 0.0, np.pi)], [20.0])
    trajectory = np.asarray(decision.plan.trajectory)
    assert decision.ambition == Ambition.STOP or is_fail_safe(
        trajectory, belief.obstacles(last_step=100), 0.5
    )
    free, _ = decided(20.0, [(110.0, 0.0, np.pi)], [20.0])
    assert free.ambition == Ambition.CHANGE


@pytest.mark.parametrize("speed", [7.0, 12.0, 16.0, 18.0])
@pytest.mark.parametrize("gap", [40.0, 75.0, 110.0])
def test_at_lower_speeds_a_longer_outlook_changes_no_plan(
    monkeypatch: pytest.MonkeyPatch, speed: float, gap: float
) -> None:
    cars = [(gap, 0.0, np.pi), (30.0, 3.5, 0.1), (12.0, -3.4, 0.0)], [speed, 9.0, 0.0]
    found, _ = decided(speed, *cars)
    monkeypatch.setattr(planner_policy, "steps_to_rest", lambda *_: GOAL_STEPS[1])
    expected, _ = decided(speed, *cars)
    assert found.ambition == expected.ambition
    np.testing.assert_array_equal(found.plan.trajectory, expected.plan.trajectory)


def test_a_live_planner_drives() -> None:
    env = gym.make("avsec/ClosedLoop-v0", scenarios={"source": "layouts", "count": 1})
    driver = PlannerDriver(env, MotionPrimitivePlanner(algorithm="gbfs"))  # type: ignore[arg-type]
    assert driven(env, driver)["progress"] > 5.0


@pytest.mark.parametrize("id", ["000468", "000943"])
def test_where_the_planner_collides_no_car_could_have_avoided_it(shared: Path, id: str) -> None:
    """The certificate of the two labelled scenes that begin too near a standing car."""
    scenes = SceneSet(
        id, tuple(s for s in scene_set(shared / "safety_scenarios").labelled if s.id == id)
    )
    (scene,) = scenes.labelled
    for intention in Intention:
        assert run_episode(scene, intention).record.reason == "unreachable"
    # Neither braking nor swerving within the friction circle keeps the car off it.
    nearest = int(np.argmin(scene.boxes.poses[:, 0]))
    x, y, _ = scene.boxes.poses[nearest]
    gap = x - 0.5 * scene.boxes.length[nearest] - 0.5 * BMW_320I.length
    braking = scene.start_speed**2 / (2 * BMW_320I.max_acceleration)
    aside = 0.5 * BMW_320I.max_acceleration * (gap / scene.start_speed) ** 2
    assert scene.speeds[nearest] == 0.0
    assert gap < braking
    assert aside < 0.5 * (scene.boxes.width[nearest] + BMW_320I.width) - abs(y)
    env = gym.make("avsec/ClosedLoop-v0", scenarios=scenes)
    assert driven(env, PlannerDriver(env))["outcome"] == "collision"
