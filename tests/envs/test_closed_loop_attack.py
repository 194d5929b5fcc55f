"""`avsec/ClosedLoopAttack-v0`, beside what holds for every environment."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch

import avsec_gym  # noqa: F401 - registers the environments
from avsec_gym import registry
from avsec_gym.attacks.patch_files import Patch
from avsec_gym.boxes import Boxes3D
from avsec_gym.closed_loop.attack.drive_attack import DriveAttack
from avsec_gym.closed_loop.error_model.model import ErrorModel, write_error_model
from avsec_gym.closed_loop.loop_scenes import LoopScenes
from avsec_gym.closed_loop.perception import BlindPerception, SensorPerception, TruthPerception
from avsec_gym.closed_loop.surroundings import Surroundings
from avsec_gym.closed_loop.tracks import Tracks
from avsec_gym.closed_loop.traffic_scene import TrafficScene, thesis_road
from avsec_gym.envs.idm_driver import IdmDriver
from avsec_gym.envs.planner_driver import PlannerDriver
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.pipeline import Perception, Pipeline
from avsec_gym.rig import kitti_rig, resized_rig
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.planning_scenario import EgoState

FEW = {"source": "layouts", "count": 4}
OFF = np.array([-1.0, 0, 0, 0, -1, 0, 0])
HIDE_AHEAD = np.array([-1.0, 0, 0, 0, 1, 0.0, 0.0])
GHOST_AHEAD = np.array([1.0, -0.5, 0, 0, -1, 0, 0])


def scene_of(id: str, places: list[tuple[float, float]], speed: float, width: float) -> LoopScenes:
    """One scene on the thesis' lanes, with cars at some places that go one speed along the road."""
    count = len(places)
    tracks = Tracks.at_constant_velocity(
        np.full(count, "Car"),
        np.tile([1.5, width, 4.0], (count, 1)),
        np.array([(x, y, 0.0) for x, y in places]),
        np.full(count, speed),
        np.full(count, 1.65),
        300,
    )
    scene = TrafficScene(
        id, thesis_road(), RoadType.STREET, EgoState(velocity=6.0), tracks, (6.0, 8.0)
    )
    return LoopScenes((id,), lambda id: scene)


LEAD = scene_of("lead", [(18.0, y) for y in (-3.5, 0.0, 3.5)], 4.0, 3.0)
"""Slower cars side by side, which the car has to follow to its goal."""
WALL = scene_of("wall", [(25.0, y) for y in (-3.5, 0.0, 3.5)], 0.0, 3.0)
"""Cars that stand across all lanes: no goal is reached."""
BEHIND = scene_of("behind", [(-14.0, 0.0)], 6.0, 1.7)
"""A car behind, in the same lane."""
WHOLE_TIME = {"frames": 80, "energy": 80.0}


def made(**arguments: Any) -> Any:
    return gym.make("avsec/ClosedLoopAttack-v0", **({"scenarios": FEW} | arguments))


def play(env: Any, action: Any, seed: int = 0, **options: Any) -> tuple[float, dict[str, Any]]:
    """The return and the last info of an episode with one action."""
    env.reset(seed=seed, options=options)
    total, ended, info = 0.0, False, {}
    while not ended:
        _, reward, terminated, truncated, info = env.step(action)
        total, ended = total + reward, terminated or truncated
    return total, info


def test_without_an_attack_it_is_the_planners_drive() -> None:
    """The same outcome, way and distances as `avsec/ClosedLoop-v0` has."""
    env = made()
    reward, info = play(env, OFF, seed=3)
    assert (reward, info["is_success"], info["frames"], info["energy"]) == (0.0, False, 0, 0.0)
    assert info["unattacked_safe"]
    alone = gym.make("avsec/ClosedLoop-v0", scenarios=FEW)
    driver = PlannerDriver(alone)
    where = {"scenario": info["scenario"], "intention": info["intention"]}
    seen, expected = alone.reset(seed=0, options=where)
    ended = False
    while not ended:
        seen, _, terminated, truncated, expected = alone.step(driver.predict(seen)[0])
        ended = terminated or truncated
    for name in ("outcome", "path_length", "smallest_distance", "navsim_score", "cost"):
        assert info[name] == expected[name]


def test_hiding_what_is_ahead_makes_the_car_hit_it() -> None:
    env = made(scenarios=LEAD, **WHOLE_TIME)
    reward, info = play(env, HIDE_AHEAD, intention="straight")
    assert (info["outcome"], info["at_fault"], info["is_success"]) == ("collision", 1.0, True)
    assert info["hidden"] == 1
    assert reward == pytest.approx(1.0 - 0.1 * info["energy"] / 80.0)
    # Unattacked, the car follows it.
    _, info = play(env, OFF, intention="straight")
    assert (info["outcome"], info["is_success"]) == ("goal", False)


def test_a_drive_that_is_unsafe_anyway_cannot_be_won() -> None:
    """The way is blocked: the goal is never reached, whatever the attacker does."""
    env = made(scenarios=WALL, **WHOLE_TIME)
    reward, info = play(env, HIDE_AHEAD, scenario="wall", intention="straight")
    assert not info["unattacked_safe"]
    assert (info["outcome"], info["is_success"]) == ("collision", False)
    assert reward < 0
    with pytest.raises(ConfigurationError, match="driven safely without an attack, so"):
        env.reset(seed=0, options={"intention": "straight"})


def test_contested_drives_are_those_that_a_blind_car_makes_unsafely() -> None:
    straight = {"intention": "straight"}
    contested = made(scenarios=LEAD, contested=True)
    assert contested.reset(seed=0, options=straight)[1]["unattacked_safe"]
    # Without anything in the way every drive is safe, a blind car's too.
    made(scenarios=BEHIND).reset(seed=0, options=straight)
    with pytest.raises(ConfigurationError, match="unsafely by a blind car"):
        made(scenarios=BEHIND, contested=True).reset(seed=0, options=straight)


def test_a_crash_that_is_the_others_fault_does_not_count() -> None:
    """A ghost makes the car brake, and the one behind, which plays its track, runs into it."""
    env = made(scenarios=BEHIND, **WHOLE_TIME)
    _, info = play(env, OFF, intention="straight")
    assert info["outcome"] == "goal"
    across = {"name": "ghost", "ghosts": 3, "hides": 0}
    env = made(scenarios=BEHIND, kind=across, **WHOLE_TIME)
    wall = np.concatenate([[1.0, -0.5, left, 0.0] for left in (-0.4, 0.0, 0.4)])
    _, info = play(env, wall, intention="straight")
    assert info["unattacked_safe"]
    assert (info["outcome"], info["at_fault"], info["is_success"]) == ("collision", 0.0, False)


def test_the_budget_of_frames_and_of_energy_ends_the_attack() -> None:
    for frames, energy, spent in ((3, 80.0, 3), (80, 2.0, 4)):
        env = made(frames=frames, energy=energy)
        env.reset(seed=0)
        ghosts, rewards = [], []
        for _ in range(8):
            _, reward, *_, info = env.step(GHOST_AHEAD)
            ghosts.append(info["ghosts"])
            rewards.append(reward)
        assert ghosts == [1] * spent + [0] * (8 - spent)
        assert info["frames"] == spent
        assert info["energy"] == pytest.approx(0.5 * spent)
        assert rewards == pytest.approx([-0.1 * 0.5 / energy] * spent + [0.0] * (8 - spent))


def test_a_ghost_is_believed_in_the_frame_after_the_action_and_stays() -> None:
    env = made()
    played: Any = env.unwrapped
    env.reset(seed=0)
    before, start = len(played.drive.belief.poses), played.drive.state
    seen = []
    for _ in range(4):
        env.step(GHOST_AHEAD)
        seen.append(played.drive.belief.poses[-1])
    assert len(played.drive.belief.poses) == before + 1
    assert seen[0][0] == pytest.approx(start.x + 15.0)
    for pose in seen[1:]:
        np.testing.assert_allclose(pose, seen[0], atol=1e-9)
    env.step(OFF)
    assert len(played.drive.belief.poses) == before


def test_an_error_model_errs_alike_with_and_without_the_attack(tmp_path: Path) -> None:
    """Up to the attack the drives are one; a ghost comes on top of what the model makes up."""
    write_error_model(tmp_path / "half.json", ErrorModel(found=(0.5, 0.0, 0.0, 0.0, 0.0, 0.0)))
    perception = {"name": "error_model", "model": str(tmp_path / "half.json")}
    env = made(scenarios=LEAD, perception=perception)
    played: Any = env.unwrapped
    where = {"scenario": "lead", "intention": "straight"}
    _, info = play(env, OFF, **where)
    known = played.unattacked.record("lead", Intention.STRAIGHT)
    assert info["outcome"] == known.outcome
    assert info["path_length"] == known.path_length
    believed = []
    for action in (OFF, GHOST_AHEAD):
        env.reset(seed=0, options=where)
        env.step(action)
        believed.append(played.drive.belief.poses)
    np.testing.assert_array_equal(believed[1][:-1], believed[0])
    np.testing.assert_allclose(believed[1][-1, :2], [15.0, 0.0], atol=1e-6)


class Watched:
    """A perception that knows everything; its validator raises an alarm about every frame."""

    def begin(self, seed: int) -> None:
        """Nothing to forget."""

    def perceive(self, surroundings: Any) -> Any:
        boxes = surroundings.boxes
        alarm: Any = SimpleNamespace(alarm=True)
        return Perception(boxes, boxes, surroundings.road_type, validation=alarm)


@pytest.mark.parametrize("response", ["stop", None])
def test_an_alarm_takes_the_success_of_a_car_that_drives_on(response: str | None) -> None:
    env = made(scenarios=LEAD, perception=Watched(), response=response, **WHOLE_TIME)
    _, info = play(env, HIDE_AHEAD, intention="straight")
    assert info["outcome"] == "collision"
    assert info["alarms"] > 10
    assert info["is_success"] == (response is not None)


@pytest.mark.parametrize("name", ["policy_frequency", "simulation_frequency"])
def test_an_attacks_frames_are_tenths_of_a_second(name: str) -> None:
    with pytest.raises(ConfigurationError, match=f"leave {name} at"):
        made(config={name: 5})
    with pytest.raises(ConfigurationError, match="dictionary"):
        made(config=name)


@pytest.mark.parametrize("kind", ["facula", "spoofed_scan", "patch"])
def test_no_attack_on_sensors_is_played_where_none_is_read(kind: str) -> None:
    for perception in (TruthPerception(), BlindPerception()):
        with pytest.raises(ConfigurationError, match="does not read"):
            made(kind=kind, perception=perception)


class LightMeter:
    """A detector that finds nothing, and notes how many pixels of the left image are bright."""

    def __init__(self) -> None:
        self.bright: list[int] = []

    def detect(self, frame: SensorFrame) -> Boxes3D:
        self.bright.append(int((frame.image(2)[..., 0] > 200).sum()))
        return Boxes3D.empty()


def test_a_poster_on_the_vehicle_ahead_grows_in_what_the_car_sees() -> None:
    """The car, which sees nothing, closes in on it until it crashes."""
    rig = resized_rig(kitti_rig(), 310)
    black = np.zeros((94, 310, 3), np.uint8)
    frame = SensorFrame("000000", rig.calibration, {2: black, 3: black})
    scene = replace(LEAD.scene("lead"), sensors=lambda *_: frame)
    meter: Any = LightMeter()
    white = Patch(torch.full((3, 8, 8), 255.0))
    env = made(
        kind={"name": "patch", "patch": white},
        scenarios=LoopScenes(("lead",), lambda id: scene),
        perception=SensorPerception(Pipeline(meter)),
        motion="static",
        **WHOLE_TIME,
    )
    on = np.array([1.0, 1.0, -0.375, 0.0, 1.0])
    _, info = play(env, on, intention="straight", scenario="lead")
    assert (info["outcome"], info["carried"], info["diameter"]) == ("collision", 1.0, 2.0)
    # That drive comes after the one without the attack, whose frames are black.
    lit = [count for count in meter.bright if count]
    assert len(lit) > 3
    assert lit == sorted(lit)
    assert lit[-1] > 4 * lit[0]


class Clock(DriveAttack):
    """Does nothing, and notes the truth's time at every action."""

    action_size, state_size, facts = 1, 1, {}

    def __init__(self) -> None:
        self.times: list[float] = []

    def begin(self) -> None:
        """Nothing is up."""

    def act(self, action: np.ndarray, around: Surroundings) -> float:
        self.times.append(around.time)
        return 0.0

    def state(self, around: Surroundings) -> np.ndarray:
        return np.zeros(1)


class WatchedFrames(Watched):
    """One of sensors: frames that are not read may be left out."""

    frame_by_frame = True


def test_alarms_come_with_the_frames_that_are_perceived_and_attacks_see_every_instant() -> None:
    """The planner reads a frame in five: 17 of 81, the start's among them."""
    for watched, alarms in ((Watched(), 81), (WatchedFrames(), 17)):
        clock: Any = Clock()
        env = made(scenarios=LEAD, perception=watched, kind=clock, **WHOLE_TIME)
        _, info = play(env, np.ones(1), intention="straight")
        steps = len(clock.times)
        np.testing.assert_allclose(clock.times, 0.1 * np.arange(steps))
        assert info["alarms"] == (steps + 1 if alarms == 81 else steps // 5 + 1)


class Still:
    """An agent that holds the wheel straight and its speed."""

    def predict(self, observation: Any, deterministic: bool = False) -> tuple[np.ndarray, None]:
        assert deterministic
        return np.zeros(2, np.float32), None


def test_another_driver_drives() -> None:
    """One that looks at nothing is harmed by nothing."""
    env = made(driver=Still(), scenarios={"source": "layouts", "count": 12})
    clean, attacked = play(env, OFF, seed=1)[1], play(env, HIDE_AHEAD, seed=1)[1]
    assert clean["outcome"] == attacked["outcome"] == "goal"
    assert clean["path_length"] == attacked["path_length"]
    brisk = scene_of("brisk", [(25.0, 0.0)], 6.0, 1.7)
    follower = made(driver="idm", scenarios=brisk, **WHOLE_TIME)
    assert isinstance(follower.unwrapped.driver, IdmDriver)
    ways = [play(follower, action, intention="straight")[1] for action in (OFF, HIDE_AHEAD)]
    assert [info["outcome"] for info in ways] == ["goal", "goal"]
    assert ways[1]["cost"] < ways[0]["cost"] - 0.2, "with nothing ahead it drives faster"
    quick = made(driver={"name": "planner", "replanning": 0.2}).unwrapped.driver
    assert quick.policy.replanning == 0.2


def test_what_cannot_drive_is_refused() -> None:
    for wrong, message in (
        ("planer", 'mean "planner"'),
        (5, "predict"),
        ({"name": "planner", "replan": 1}, 'mean "replanning"'),
        (PlannerDriver(gym.make("avsec/ClosedLoop-v0")), "made for"),
    ):
        with pytest.raises(ConfigurationError, match=message):
            made(driver=wrong)


def test_an_attack_that_the_perception_does_not_read_is_refused() -> None:
    for kind in ("facula", "spoofed_scan", "patch"):
        with pytest.raises(ConfigurationError, match='perception="sensors"'):
            made(kind=kind)
    with pytest.raises(ConfigurationError, match='perception="truth"'):
        made(perception="sensors", scenarios="drives")


class Fog(DriveAttack):
    """Hides everything: an attack of a package of its own."""

    action_size, state_size = 1, 1

    def begin(self) -> None:
        self.up = False

    def act(self, action: np.ndarray, around: Surroundings) -> float:
        self.up = bool(action[0] > 0)
        return float(self.up)

    def state(self, around: Surroundings) -> np.ndarray:
        return np.array([float(self.up)])

    @property
    def facts(self) -> dict[str, float]:
        return {"fog": float(self.up)}

    def believed(self, perception: Perception, around: Surroundings) -> Perception:
        return replace(perception, believed=perception.believed[:0]) if self.up else perception


def test_a_kind_of_another_package_plays_by_its_name(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fog for the whole time is a blind car's drive, from the first frame after the start on."""
    monkeypatch.setattr(registry, "_REGISTERED", dict(registry._REGISTERED))
    registry.register("drive_attack", "fog", Fog)
    env = made(kind="fog", scenarios=LEAD, **WHOLE_TIME)
    assert env.observation_space.shape == (162 + 1 + 1,)
    _, info = play(env, np.ones(1), intention="straight")
    assert (info["outcome"], info["is_success"], info["fog"]) == ("collision", True, 1.0)
    with pytest.raises(ConfigurationError, match='mean "fog"'):
        made(kind="fogg")


def test_the_observation_has_the_documented_size() -> None:
    assert made().observation_space.shape == (177,)
    kind: Any = {"name": "ghost", "ghosts": 2, "hides": 0}
    live: DriveAttack = made(kind=kind).unwrapped.attack
    assert made(kind=kind).observation_space.shape == (162 + live.state_size + 8,)


@pytest.mark.slow
def test_ppo_learns_in_it() -> None:
    from stable_baselines3 import PPO

    env = made()
    model = PPO("MlpPolicy", env, n_steps=32, batch_size=16, n_epochs=1, seed=0)
    model.learn(64)
    observation, _ = env.reset(seed=0)
    assert env.action_space.contains(model.predict(observation)[0])
