"""Perception by what the sensors deliver."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import avsec_gym  # noqa: F401 - registers the environments
from avsec_gym.attacks.facula import Facula
from avsec_gym.boxes import Boxes3D
from avsec_gym.closed_loop.drive_log import DriveLog
from avsec_gym.closed_loop.error_model.model import ErrorModel, write_error_model
from avsec_gym.closed_loop.loop_scenes import LoopScenes
from avsec_gym.closed_loop.perception import SensorPerception
from avsec_gym.closed_loop.procedural_drives import procedural_drive
from avsec_gym.closed_loop.relative_poses import Pose, seen_from
from avsec_gym.closed_loop.rendered_sensors import RenderedSensors
from avsec_gym.closed_loop.traffic_scene import TrafficScene
from avsec_gym.envs.planner_driver import PlannerDriver
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import ego_to_camera
from avsec_gym.pipeline import Pipeline
from avsec_gym.rig import kitti_rig, resized_rig


class Looking:
    """A detector that keeps the frames, and always finds the same car 20 m ahead."""

    def __init__(self) -> None:
        self.frames: list[SensorFrame] = []

    def detect(self, frame: SensorFrame) -> Boxes3D:
        self.frames.append(frame)
        return Boxes3D(
            np.array([[0.0, 1.65, 20.0]]),
            np.array([[1.5, 1.8, 4.2]]),
            np.array([-np.pi / 2]),
            np.array([0.9]),
            np.array(["Car"]),
        )


def test_a_detector_sees_frames_from_where_the_car_is() -> None:
    scene = procedural_drive(0, 3, rig=resized_rig(kitti_rig(), 160))
    detector: Any = Looking()
    env = gym.make(
        "avsec/ClosedLoop-v0",
        scenarios=LoopScenes((scene.id,), lambda id: scene),
        perception=SensorPerception(Pipeline(detector)),
        motion="static",
    )
    played: Any = env.unwrapped
    env.reset(seed=0)
    state, belief = played.state, played.belief
    ahead = state.x + 20.0 * np.cos(state.heading), state.y + 20.0 * np.sin(state.heading)
    np.testing.assert_allclose(belief.poses[0, :2], ahead, atol=1e-6)
    assert belief.speeds.tolist() == [0.0]
    env.step(np.zeros(2))
    first, second = detector.frames
    assert first.images[2].shape == (48, 160, 3)
    assert first.has_points
    assert not np.array_equal(first.images[2], second.images[2])


def test_a_light_stays_where_it_is_while_the_car_drives_on() -> None:
    scene = procedural_drive(0, 3, rig=resized_rig(kitti_rig(), 160))

    def lit(seed: int, attack: Any) -> list[Any]:
        detector: Any = Looking()
        env = gym.make(
            "avsec/ClosedLoop-v0",
            scenarios=LoopScenes((scene.id,), lambda id: scene),
            perception=SensorPerception(Pipeline(detector, attack=attack)),
            motion="static",
        )
        env.reset(seed=seed)
        env.step(np.zeros(2))
        return [frame.images[2].astype(float) for frame in detector.frames]

    facula = Facula(camera=2)
    clean, attacked, others = lit(0, None), lit(0, facula), lit(1, facula)
    spots = [
        np.argwhere(shone - dark > 60.0).mean(axis=0)
        for shown in (attacked, others)
        for shone, dark in zip(shown, clean, strict=True)
    ]
    assert spots[0] == pytest.approx(spots[1], abs=2.0)
    # Another drive has its light elsewhere.
    assert np.abs(spots[0] - spots[2]).max() > 4.0


def test_what_is_ahead_of_the_car_is_so_far_from_its_camera() -> None:
    """A lorry that is put 15 m ahead of the car ends the rays that look there."""
    scene = procedural_drive(0, 3, rig=resized_rig(kitti_rig(), 160))
    tracks, sensors = scene.tracks, scene.sensors
    assert isinstance(sensors, RenderedSensors)
    row = int(np.argmax(tracks.dimensions[:, 2] * (tracks.first == 0)))
    start = scene.start
    cos, sin = np.cos(start.heading), np.sin(start.heading)
    put = (start.x + 15.0 * cos, start.y + 15.0 * sin, start.heading)
    frame = sensors(0.0, (start.x, start.y, start.heading), {int(tracks.ids[row]): put})
    points = frame.points @ np.eye(4)[:, :3]
    calibration = frame.calibration
    transform = calibration.velodyne_to_camera
    seen = points @ transform[:3, :3].T + transform[:3, 3]
    ahead = seen[
        (np.abs(seen[:, 0]) < 0.5) & (seen[:, 1] < 1.0) & (seen[:, 1] > 0.3) & (seen[:, 2] > 2)
    ]
    rear = 15.0 - 0.5 * tracks.dimensions[row, 2]
    assert ahead[:, 2].min() == pytest.approx(rear, abs=0.6)


def test_errors_are_drawn_from_a_file(tmp_path: Path) -> None:
    blind = ErrorModel(found=(-50.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    for name, model in (("sure", ErrorModel()), ("blind", blind)):
        write_error_model(tmp_path / f"{name}.json", model)
    seen = {}
    for name in ("sure", "blind"):
        chosen = {"name": "error_model", "model": str(tmp_path / f"{name}.json")}
        env = gym.make(
            "avsec/ClosedLoop-v0", scenarios={"source": "layouts", "count": 3}, perception=chosen
        )
        env.reset(seed=0)
        played: Any = env.unwrapped
        seen[name] = len(played.belief.poses)
    assert seen["sure"] > 0 == seen["blind"]
    for wrong, problem in (
        ("error_model", "names it"),
        ({"name": "error_model", "modle": "x"}, "model"),
        ({"name": "error_model", "model": 3}, "file"),
    ):
        with pytest.raises(ConfigurationError, match=problem):
            gym.make("avsec/ClosedLoop-v0", perception=wrong)
    with pytest.raises(DataError, match=r"gone\.json"):
        gym.make("avsec/ClosedLoop-v0", perception={"name": "error_model", "model": "gone.json"})


class Sign:
    """Sensors and a detector at once: what stands 70 m down the lane is found from wherever."""

    def __init__(self, scene: TrafficScene) -> None:
        line = scene.lanes.line(scene.start_lane)
        along, _ = line.coordinates(scene.start.x, scene.start.y)
        self.place = np.array([line.pose(along + 70.0)])
        self.times: list[float] = []

    def __call__(self, time: float, pose: Pose, others: dict[int, Pose]) -> SensorFrame:
        self.times.append(time)
        self.pose = pose
        black = np.zeros((48, 160, 3), np.uint8)
        rig = resized_rig(kitti_rig(), 160)
        return SensorFrame("000000", rig.calibration, {2: black, 3: black})

    def detect(self, frame: SensorFrame) -> Boxes3D:
        location, rotation_y = ego_to_camera(seen_from(self.pose, self.place), 1.65)
        size = np.array([[1.5, 60.0, 1.0]])  # Across all lanes.
        return Boxes3D(location, size, rotation_y, np.ones(1), np.array(["Car"]))


class EveryFrame(SensorPerception):
    """One that may not leave a frame out."""

    frame_by_frame = False


def test_a_planner_has_only_those_frames_rendered_that_it_plans_on() -> None:
    """The drive is the one with all frames; an agent that reads every belief gets every frame."""
    scene = procedural_drive(0, 3, rig=resized_rig(kitti_rig(), 160))
    scene = replace(scene, tracks=scene.tracks[np.zeros(len(scene.tracks), bool)])
    driven, times = {}, {}
    for kind in (SensorPerception, EveryFrame):
        sign: Any = Sign(scene)
        seen = replace(scene, sensors=sign)
        env = gym.make(
            "avsec/ClosedLoop-v0",
            scenarios=LoopScenes((scene.id,), lambda id, seen=seen: seen),
            perception=kind(Pipeline(sign)),
            motion="static",
        )
        driver = PlannerDriver(env, replanning=0.4)
        driven[kind], times[kind] = driven_by(env, driver), sign.times
    first, second = driven[SensorPerception], driven[EveryFrame]
    np.testing.assert_array_equal(first.car, second.car)
    assert first.car[-1, 2] < 1.0, "the car has braked for the sign"
    steps = len(times[EveryFrame]) - 1
    np.testing.assert_allclose(times[EveryFrame], 0.1 * np.arange(steps + 1))
    np.testing.assert_allclose(times[SensorPerception], 0.4 * np.arange(steps // 4 + 1))
    # The same environment, driven by another agent.
    sign.times.clear()
    env = gym.make(
        "avsec/ClosedLoop-v0",
        scenarios=LoopScenes((scene.id,), lambda id: replace(scene, sensors=sign)),
        perception=SensorPerception(Pipeline(sign)),
        motion="static",
    )
    driver = PlannerDriver(env)
    driver.predict(env.reset(seed=0)[0])
    for _ in range(6):
        env.step(np.zeros(2, np.float32))
    assert len(sign.times) == 6, "the first step alone was the planner's"


def driven_by(env: Any, driver: PlannerDriver) -> DriveLog:
    seen, _ = env.reset(seed=0, options={"intention": "straight"})
    while env.unwrapped.outcome is None:
        seen, *_ = env.step(driver.predict(seen)[0])
    return env.unwrapped.log()


class Gradient:
    """Sensors whose left image grows brighter to the right and with time; the right is flipped."""

    image = np.repeat(np.arange(160, dtype=np.uint8)[None, :, None], 48, axis=0).repeat(3, axis=2)

    def __call__(self, time: float, pose: Pose, others: dict[int, Pose]) -> SensorFrame:
        left = self.image + np.uint8(round(100 * time))
        calibration = resized_rig(kitti_rig(), 160).calibration
        return SensorFrame("000000", calibration, {2: left, 3: left[:, ::-1]})


def observing(**arguments: Any) -> Any:
    scene = replace(procedural_drive(0, 3), sensors=Gradient())
    detector: Any = Looking()
    return gym.make(
        "avsec/ClosedLoop-v0",
        scenarios=LoopScenes((scene.id,), lambda id: scene),
        perception=SensorPerception(Pipeline(detector)),
        motion="static",
        observation="frame",
        **arguments,
    )


def test_a_driver_may_observe_the_frames_that_the_sensors_deliver() -> None:
    env = observing(frame_size=(48, 160))
    plain = env.unwrapped.observation_space["features"]
    seen, _ = env.reset(seed=0)
    for steps in range(3):
        expected = Gradient.image + np.uint8(10 * steps)
        np.testing.assert_array_equal(seen["left"], expected)
        np.testing.assert_array_equal(seen["right"], expected[:, ::-1])
        assert plain.contains(seen["features"])
        kept = seen["left"].copy()
        following, *_ = env.step(np.zeros(2, np.float32))
        np.testing.assert_array_equal(seen["left"], kept, "no array is shared")
        seen = following
    # Smaller, each pixel is the mean of the four that it stands for.
    small, _ = observing(frame_size=[24, 80]).reset(seed=0)
    np.testing.assert_allclose(small["left"][0, :, 0], np.arange(80) * 2 + 0.5, atol=0.5)


def test_an_environment_of_frames_is_one_for_stable_baselines() -> None:
    from stable_baselines3 import PPO
    from stable_baselines3.common.env_checker import check_env

    env = observing(duration=0.5)
    check_env(env, warn=True)
    model = PPO("MultiInputPolicy", env, n_steps=8, batch_size=8, n_epochs=1, seed=0)
    assert sum(each.numel() for each in model.policy.parameters()) < 5e6
    model.learn(8)


STEREO = {"scenarios": "drives", "perception": "stereo"}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({}, "does not read any"),
        ({"scenarios": "drives", "perception": "lidar"}, "does not read any"),
        ({"observation": "frames"}, 'mean "frame"'),
        (STEREO | {"config": {"observation": {"type": "Kinematics"}}}, "give one"),
        (STEREO | {"frame_size": (48,)}, "height and a width"),
        (STEREO | {"frame_size": (48, 0)}, "frame_size"),
    ],
)
def test_frames_that_are_not_rendered_are_not_observed(
    arguments: dict[str, Any], message: str
) -> None:
    with pytest.raises(ConfigurationError, match=message):
        gym.make("avsec/ClosedLoop-v0", **({"observation": "frame"} | arguments))
