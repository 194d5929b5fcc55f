"""`avsec/ClosedLoop-v0`, beside what holds for every environment."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from highway_env.envs.common.abstract import AbstractEnv

from avsec_gym.closed_loop.drive_log import first_contact
from avsec_gym.closed_loop.perception import TruthPerception
from avsec_gym.closed_loop.procedural_drives import procedural_drive
from avsec_gym.closed_loop.road_network import CurvedLane
from avsec_gym.closed_loop.surroundings import Surroundings
from avsec_gym.envs.planner_driver import PlannerDriver
from avsec_gym.errors import ConfigurationError
from avsec_gym.evaluation.contested import contested_layouts
from avsec_gym.geometry import wrap_angle
from avsec_gym.pipeline import Perception
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Motion
from avsec_gym.validation.validator import Judgement

FEW = {"source": "layouts", "count": 4}


def made(scenarios: Any = FEW, **arguments: Any) -> Any:
    return gym.make("avsec/ClosedLoop-v0", scenarios=scenarios, **arguments)


def test_it_is_an_environment_of_highway_env() -> None:
    env = made(config={"policy_frequency": 5}).unwrapped
    assert isinstance(env, AbstractEnv)
    env.reset(seed=0)
    env.step(np.zeros(2))
    assert env.elapsed == pytest.approx(0.2)
    assert env.vehicle in env.road.vehicles


def test_full_braking_stops_after_half_of_v_squared_by_a() -> None:
    env = made().unwrapped
    env.reset(seed=0)
    begin = env.state
    for _ in range(30):
        env.step(np.array([-1.0, 0.0]))
    assert env.state.velocity == 0.0
    assert env.state.x - begin.x == pytest.approx(begin.velocity**2 / 16.0, abs=1e-6)


def test_steering_to_the_right_goes_to_the_right() -> None:
    env = made().unwrapped
    env.reset(seed=0)
    for _ in range(5):
        env.step(np.array([0.0, 0.1]))
    assert env.state.y < 0.0
    assert env.state.heading < 0.0


def test_eight_seconds_are_eighty_steps() -> None:
    env = made()
    env.reset(seed=0)
    for step in range(1, 81):
        *_, terminated, truncated, info = env.step(np.array([-0.6, 0.0], np.float32))
        assert not terminated
        assert truncated == (step == 80)
    assert info["outcome"] == "stopped"
    assert info["cost"] != info["cost"]


def test_driving_straight_on_ends_where_highway_env_sees_the_crash() -> None:
    """The outcome is shapely's; highway-env's own test of the same rectangles agrees."""
    collisions = 0
    env = made().unwrapped
    for seed in range(12):
        env.reset(seed=seed)
        ended = False
        while not ended:
            _, reward, terminated, truncated, info = env.step(np.array([0.0, 0.0]))
            ended = terminated or truncated
        if info["collision"]:
            collisions += 1
            assert reward < -0.9
            contact = first_contact(env.log())
            assert contact is not None
            hit = env.traffic.actors[contact.actor]
            assert env.vehicle._is_colliding(hit, 0.0)[0]
    assert collisions > 0


@pytest.mark.parametrize("kind", ["Kinematics", "OccupancyGrid"])
def test_highway_envs_observations_show_believed_objects(kind: str) -> None:
    shown = {}
    for level in ("truth", "blind"):
        env = made(perception=level, config={"observation": {"type": kind}})
        shown[level], _ = env.reset(seed=2)
        assert env.observation_space.contains(shown[level])
    assert np.abs(shown["truth"]).sum() > np.abs(shown["blind"]).sum()


def test_meta_actions_change_lanes_and_speeds() -> None:
    env = made(config={"action": {"type": "DiscreteMetaAction"}}, perception="blind")
    played = env.unwrapped
    env.reset(seed=0, options={"scenario": played.scenes.ids[0]})
    played.traffic.present[:] = False
    before = played.state
    left = played.action_type.actions_indexes["LANE_LEFT"]
    idle = played.action_type.actions_indexes["IDLE"]
    env.step(left)
    for _ in range(25):
        if played.outcome is None:
            env.step(idle)
    assert played.state.y - before.y > 1.0
    with pytest.raises(ConfigurationError, match="action"):
        played.step(7)


def test_wrong_configurations_are_refused() -> None:
    with pytest.raises(ConfigurationError, match="policy_frequency"):
        made(config={"policy_frequenzy": 5})
    with pytest.raises(ConfigurationError, match="dictionary"):
        made(config=5)
    with pytest.raises(ConfigurationError, match='Did you mean "Kinematics"'):
        made(config={"observation": {"type": "Kinematic"}})
    with pytest.raises(ConfigurationError, match='Did you mean "ContinuousAction"'):
        made(config={"action": {"type": "Continuous"}})
    with pytest.raises(ConfigurationError, match="no type of actions None"):
        made(config={"action": {}})
    with pytest.raises(ConfigurationError, match="sensor data"):
        made(perception="sensors", detector="oracle")
    with pytest.raises(ConfigurationError, match="name a validator"):
        made(handover=1.0)
    with pytest.raises(ConfigurationError, match="handover"):
        made(perception=Distrusting(), handover=0.0)
    with pytest.raises(ConfigurationError, match="frame_size"):
        made(frame_size="huge")
    with pytest.raises(ConfigurationError, match="MultiAgentObservation"):
        made(config={"observation": {"type": "MultiAgentObservation"}})


@pytest.mark.parametrize("frequency", [0, -5, 30, "x", 2.5, None])
def test_a_drive_that_would_never_end_is_refused(frequency: Any) -> None:
    with pytest.raises(ConfigurationError, match="policy_frequency"):
        made(config={"policy_frequency": frequency})
    played = made().unwrapped
    with pytest.raises(ConfigurationError, match="policy_frequency"):
        played.reset(seed=0, options={"config": {"policy_frequency": frequency}})
    if frequency != 30:
        with pytest.raises(ConfigurationError, match="simulation_frequency"):
            made(config={"simulation_frequency": frequency})


@pytest.mark.parametrize(
    ("perception", "part"),
    [
        ("truth", {"score_threshold": 0.9}),
        ("blind", {"response": "drop"}),
        ({"name": "error_model", "model": "dsgn"}, {"score_threshold": 0.9}),
        (TruthPerception, {"attack": "facula"}),
        (TruthPerception, {"detector": "stereo_rcnn"}),
        (TruthPerception, {"score_threshold": 0.9}),
        ("sensors", {"classifier": "small", "motion": "truth"}),
    ],
    ids=str,
)
def test_a_part_that_would_never_be_asked_is_refused(perception: Any, part: Any) -> None:
    if isinstance(perception, type):
        perception = perception()
    with pytest.raises(ConfigurationError, match=f"{next(iter(part))}.*leave"):
        made(perception=perception, scenarios="drives", **part)


def test_with_a_classifier_the_planner_reckons_with_its_answers() -> None:
    env = made(perception="sensors", scenarios="drives", detector="oracle", classifier="small")
    assert env.unwrapped.motion == Motion.CLASSIFIER


class Distrusting(TruthPerception):
    """Stops the car at an alarm, which begins after a second and goes on for some seconds."""

    def __init__(self, until: float = math.inf) -> None:
        self.until = until

    def perceive(self, surroundings: Surroundings) -> Perception:
        seen = super().perceive(surroundings)
        alarm = 1.0 <= surroundings.time < self.until
        return replace(seen, stops=alarm, validation=Judgement(alarm, {}))


def test_a_car_that_stands_by_alarms_is_handed_over() -> None:
    scores = []

    def ends(until: float, handover: float | None) -> tuple[str, float, float]:
        env = made(perception=Distrusting(until), handover=handover)
        driver = PlannerDriver(env)
        observation, info = env.reset(seed=0)
        stood = math.nan
        while True:
            action, _ = driver.predict(observation, deterministic=True)
            observation, _, terminated, truncated, info = env.step(action)
            elapsed, speed = env.unwrapped.elapsed, env.unwrapped.state.velocity
            stood = elapsed if speed <= 0.05 and math.isnan(stood) else stood
            if terminated or truncated:
                assert truncated == (info["outcome"] in ("stopped", "time"))
                scores.append(info["progress_share"])
                return info["outcome"], elapsed, stood

    outcome, elapsed, _ = ends(math.inf, None)
    assert (outcome, elapsed) == ("stopped", 8.0)
    outcome, elapsed, stood = ends(math.inf, 1.5)
    assert outcome == "stopped"
    assert stood + 1.3 < elapsed < stood + 1.7
    # Who is handed over has come no farther than who stands until the time is over.
    assert scores[1] == pytest.approx(scores[0])
    assert scores[0] < 1.0
    # An alarm that is over before that hands nothing over.
    outcome, elapsed, _ = ends(stood + 0.5, 1.5)
    assert elapsed == 8.0 or outcome == "goal"


def test_alarms_are_counted_now_and_so_far() -> None:
    env = made(perception=Distrusting(2.0))
    _, info = env.reset(seed=0)
    heard = []
    for _ in range(30):
        assert info["alarms"] == sum(heard)
        *_, info = env.step(np.zeros(2))
        heard.append(info["alarm"])
    # Each of the ten instants from 1.0 to 1.9 s.
    assert heard == [False] * 9 + [True] * 10 + [False] * 11


def test_a_procedural_drive_follows_the_worlds_road() -> None:
    scene = procedural_drive(0, 3)
    lane = scene.lanes.line(scene.start_lane)
    along, left = lane.coordinates(scene.start.x, scene.start.y)
    assert abs(left) < 1.0
    assert abs(wrap_angle(lane.heading(along) - scene.start.heading)) < 0.2
    # Actors on wheels that move are on the road, and the car itself is not among them.
    moving = np.abs(scene.tracks.speeds[:, 0]) > 2.0
    assert not (
        np.hypot(*(scene.tracks.poses[moving, 0, :2] - (scene.start.x, scene.start.y)).T) < 1.0
    ).any()
    env = gym.make("avsec/ClosedLoop-v0", scenarios={"source": "drives", "count": 4})
    driver = PlannerDriver(env)
    observation, _ = env.reset(seed=0, options={"scenario": scene.id})
    for _ in range(30):
        observation, *_ = env.step(driver.predict(observation)[0])
    played: Any = env.unwrapped
    assert played.outcome is None
    own = played.state
    assert abs(played.scene.lanes.line(scene.start_lane).coordinates(own.x, own.y)[1]) < 1.75


def test_the_picture_has_the_edges_of_a_curved_lane_where_they_are() -> None:
    env = made(scenarios="drives", render_mode="rgb_array")
    env.reset(seed=0)
    picture = env.render()
    played: Any = env.unwrapped
    assert picture.shape == (600, 600, 3)
    lane = played.road.network.get_lane(played.vehicle.lane_index)
    assert isinstance(lane, CurvedLane)
    along, _ = lane.local_coordinates(played.vehicle.position)
    surface = played.viewer.sim_surface
    for ahead, side in product((0.0, 15.0, 30.0), (-1, 1)):
        edge = lane.position(along + ahead, side * lane.width_at(along + ahead) / 2)
        column, row = surface.pos2pix(*edge)
        # A line is white, and a pixel wide.
        assert picture[row - 2 : row + 3, column - 2 : column + 3].max() == 255
        column, row = surface.pos2pix(*lane.position(along + ahead, 4.0 * side))
        assert picture[row - 2 : row + 3, column - 2 : column + 3].max() < 255


def test_a_video_is_recorded(tmp_path: Path) -> None:
    pytest.importorskip("moviepy")
    from gymnasium.wrappers import RecordVideo

    folder = tmp_path / "films"
    env = RecordVideo(made(render_mode="rgb_array"), str(folder), disable_logger=True)
    env.unwrapped.set_record_video_wrapper(env)  # type: ignore[attr-defined]
    env.reset(seed=0)
    for _ in range(5):
        env.step(env.action_space.sample())
    env.close()
    assert list(folder.glob("*.mp4"))


def test_an_intention_that_no_scene_has_a_lane_for_is_refused() -> None:
    env = gym.make("avsec/ClosedLoop-v0", scenarios={"source": "drives", "count": 2})
    scenes = env.unwrapped.scenes  # type: ignore[attr-defined]
    missing = set(Intention) - {each for id in scenes.ids for each in scenes.scene(id).intentions}
    assert missing, "a two-way street has one lane of each direction"
    with pytest.raises(ConfigurationError, match="no scene has a lane"):
        env.reset(seed=0, options={"intention": str(missing.pop())})


@pytest.mark.parametrize(
    "perception", ["truth", "blind", {"name": "error_model", "model": "stereo_rcnn"}], ids=str
)
@pytest.mark.parametrize(
    "part",
    [{"attack": {"name": "facula", "camera": 2}}, {"classifier": "small"}, {"selector": "small"},
     {"detector": "stereo_rcnn"}],
    ids=str,
)  # fmt: skip
@pytest.mark.parametrize("id", ["avsec/ClosedLoop-v0", "avsec/ClosedLoopAttack-v0"])
def test_parts_that_would_never_be_asked_are_refused(
    id: str, part: dict[str, Any], perception: Any
) -> None:
    """A car that was to be attacked drove on by the truth, without a word."""
    if id == "avsec/ClosedLoopAttack-v0" and "attack" in part:
        pytest.skip("the agent plays the attack")
    with pytest.raises(ConfigurationError, match=f"{next(iter(part))} would never be asked"):
        gym.make(id, scenarios=FEW, perception=perception, **part)


def test_contested_scenes_are_driven_in_by_name() -> None:
    env = made(scenarios={"source": "mixed_contested", "count": 2})
    ids = {env.reset(seed=seed)[1]["scenario"] for seed in range(6)}
    assert ids == {scene.id for scene in contested_layouts(2).scenes}
    with pytest.raises(ConfigurationError, match="kitti_contested are the contested ones"):
        made(scenarios="kitti_contested")
    with pytest.raises(ConfigurationError, match='Did you mean "mixed_contested"'):
        made(scenarios="mixed_contest")
