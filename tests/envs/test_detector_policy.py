"""Detectors as agents of `avsec/DetectorBenchmark-v0`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from stable_baselines3 import PPO
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.monitor import Monitor

import avsec_gym  # noqa: F401
from avsec_gym.boxes import Boxes3D
from avsec_gym.envs.detector_policy import DetectorPolicy
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti import write_detections
from avsec_gym.pipeline import run_episode
from avsec_gym.scenario.builder import is_obstacle
from avsec_gym.scenario.intention import Intention

pytestmark = pytest.mark.usefixtures("small_suite")

ID = "avsec/DetectorBenchmark-v0"


class Watcher:
    """Keeps the frames that it is shown."""

    name = "watcher"

    def __init__(self) -> None:
        self.frames: list[SensorFrame] = []

    def detect(self, frame: SensorFrame) -> Boxes3D:
        self.frames.append(frame)
        return Boxes3D.empty()


@pytest.fixture
def env() -> Any:
    made = gym.make(ID, points=1000)
    yield made
    made.close()


def test_the_oracle_drives_as_one_who_knows_the_truth(env: Any) -> None:
    policy = DetectorPolicy("oracle", env)
    for seed in range(8):
        observation, _ = env.reset(seed=seed)
        action, _ = policy.predict(observation)
        info = env.step(action)[-1]
        assert info["found"] == info["objects"]
        scenes = env.unwrapped.scenes.scenes.labelled
        scene = next(scene for scene in scenes if scene.id == info["scenario"])
        truth = scene.boxes[is_obstacle(scene.boxes)]
        believed = env.unwrapped.coding.decode(env.unwrapped.coding.encode(truth))
        expected = run_episode(scene, Intention(info["intention"]), believed, motion="static")
        assert info["outcome"] == expected.record.outcome


def test_an_observation_alone_says_what_a_detector_needs(env: Any) -> None:
    watcher = Watcher()
    observation, _ = env.reset(seed=3)
    DetectorPolicy(watcher).predict(observation)
    DetectorPolicy(watcher, env).predict(observation)
    seen, real = watcher.frames
    np.testing.assert_array_equal(seen.image(2), real.image(2))
    np.testing.assert_array_equal(seen.image(3), real.image(3))
    one, other = seen.stereo(), real.stereo()
    assert (one.focal_length, one.baseline) == (other.focal_length, other.baseline)
    assert 500 < len(seen.points) <= 1000


def test_evaluate_policy_ranks_detectors(env: Any) -> None:
    rewards, _ = evaluate_policy(
        DetectorPolicy("oracle", env),  # type: ignore[arg-type]
        Monitor(env),
        n_eval_episodes=4,
        return_episode_rewards=True,
    )
    assert set(rewards) <= {0.0, 1.0}  # type: ignore[arg-type]


def test_result_files_are_replayed(env: Any, tmp_path: Path) -> None:
    _, info = env.reset(seed=1)
    frame = env.unwrapped.frame
    truth = DetectorPolicy("oracle", env).detector.detect(frame)
    write_detections(tmp_path / f"{info['scenario']}.txt", truth)
    policy = DetectorPolicy({"name": "replayed", "detections": str(tmp_path)}, env)
    assert len(policy.detector.detect(frame)) == len(truth)
    env.reset(seed=1)
    assert env.step(policy.predict(env.unwrapped._observe())[0])[-1]["found"] == len(
        truth[is_obstacle(truth)]
    )


def test_many_observations_at_once_need_a_detector_that_looks(env: Any) -> None:
    observation, _ = env.reset(seed=0)
    stacked = {name: np.stack([part, part]) for name, part in observation.items()}
    assert DetectorPolicy(Watcher()).predict(stacked)[0].shape == (2, 400)
    with pytest.raises(ConfigurationError, match="plays that one alone"):
        DetectorPolicy(Watcher(), env).predict(stacked)


def test_thumbnails_are_the_images_made_small_with_their_own_calibration(env: Any) -> None:
    small = gym.make(ID, observation="thumbnails")
    seen, full = small.reset(seed=3)[0], env.reset(seed=3)[0]
    assert {name: space.shape for name, space in small.observation_space.spaces.items()} == {
        "left": (48, 160, 3),
        "right": (48, 160, 3),
        "calibration": (24,),
    }
    height, width = full["left"].shape[:2]
    # A grey pixel is the mean of its part of the image; a place lies at the same share of both.
    assert abs(float(seen["left"].mean()) - float(full["left"].mean())) < 1.0
    place = np.array([1.0, 1.5, 12.0, 1.0])
    for first in (0, 12):
        (u, v, w), (x, y, z) = (
            each["calibration"][first : first + 12].reshape(3, 4) @ place for each in (seen, full)
        )
        assert (u / w + 0.5) / 160 == pytest.approx((x / z + 0.5) / width)
        assert (v / w + 0.5) / 48 == pytest.approx((y / z + 0.5) / height)
    model = PPO("MultiInputPolicy", small, n_steps=4, batch_size=4)
    assert sum(each.numel() for each in model.policy.parameters()) < 5_000_000
    small.close()
