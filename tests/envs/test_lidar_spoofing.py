"""`avsec/LidarSpoofing-v0`: where bogus points go, what the car sees, what raises an alarm."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import avsec_gym  # noqa: F401
from avsec_gym.attacks.lidar_spoofing import LidarSpoofing
from avsec_gym.boxes import Boxes3D
from avsec_gym.envs.lidar_spoofing import LidarSpoofingEnv
from avsec_gym.envs.sensor_attack_features import SIZE
from avsec_gym.envs.spoofing_coding import SpoofingCoding
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.rig import kitti_rig

ID = "avsec/LidarSpoofing-v0"
CODING = SpoofingCoding()
POSE = kitti_rig().velodyne_pose
EMPTY_LANE = {"scenario": "000001", "intention": "straight"}


class Watcher:
    """Keeps what it is shown, and sees nothing."""

    name = "watcher"

    def __init__(self) -> None:
        self.frames: list[SensorFrame] = []

    def detect(self, frame: SensorFrame) -> Boxes3D:
        self.frames.append(frame)
        return Boxes3D.empty()


@pytest.fixture
def scenarios(quick: dict[str, Any]) -> str:
    return str(quick["scenarios"])


def test_actions_and_bogus_returns_convert() -> None:
    low, high = CODING.decode(-np.ones(4)), CODING.decode(np.ones(4))
    assert (low.distance, low.bearing, low.width, low.height) == (5, -0.7, 0.5, 0.5)
    assert (high.distance, high.bearing, high.width, high.height) == (40, 0.7, 2.5, 1.5)
    for action in np.random.default_rng(0).uniform(-1, 1, (20, 4)):
        np.testing.assert_allclose(CODING.encode(CODING.decode(action)), action, atol=1e-12)


@pytest.mark.parametrize("rays_lost", [False, True])
def test_the_scan_gets_the_points_of_the_patch(scenarios: str, rays_lost: bool) -> None:
    watcher = Watcher()
    env = gym.make(ID, scenarios=scenarios, detector=watcher, validator=None, rays_lost=rays_lost)
    env.reset(options=EMPTY_LANE)
    clean, lost = watcher.frames[-1], []
    for action in np.random.default_rng(1).uniform(-1, 1, (5, 4)):
        *_, info = env.step(action)
        seen = watcher.frames[-1]
        bogus = seen.points[len(seen.points) - info["points"] :, :3].astype(float)
        ahead, left, up = (bogus @ POSE[:3, :3].T).T
        cos, sin = np.cos(info["bearing"]), np.sin(info["bearing"])
        np.testing.assert_allclose(ahead * cos + left * sin, info["distance"], atol=0.06)
        assert np.abs(left * cos - ahead * sin).max() <= info["width"] / 2 + 0.06
        assert up.min() + POSE[2, 3] > -0.06
        assert up.max() + POSE[2, 3] <= info["height"] + 0.06
        kept = len(seen.points) - len(bogus)
        lost.append(len(clean.points) - kept)
        np.testing.assert_array_equal(seen.image(2), clean.image(2))
    assert min(lost) >= 0
    assert (max(lost) > 0) == rays_lost


def test_a_patch_in_the_lane_stops_the_car_and_one_beside_it_does_not(scenarios: str) -> None:
    """The smaller patch, which does as well, is cheaper."""
    env = LidarSpoofingEnv(scenarios=scenarios, validator=None)
    rewards = {}
    for width in (0.5, 2.5):
        _, clean = env.reset(options=EMPTY_LANE)
        action = env.coding.encode(LidarSpoofing(width, 1.0, 6.0, 0.0))
        seen, rewards[width], terminated, _, info = env.step(action)
        assert (info["outcome"], info["is_success"], terminated) == ("unplanned", True, True)
        assert (info["alarm"], info["ghosts"] - clean["ghosts"]) == (False, 1)
        assert rewards[width] == pytest.approx(1 - 0.02 * (1 + width / (2.5 * 1.5)))
        np.testing.assert_allclose(seen[SIZE + 5 :], action, atol=1e-6)
    assert rewards[0.5] > rewards[2.5]
    for distance, bearing in ((6.0, 0.65), (12.0, 0.0)):  # Beside it, or so far that it is passed.
        env.reset(options=EMPTY_LANE)
        *_, info = env.step(env.coding.encode(LidarSpoofing(0.5, 1.0, distance, bearing)))
        assert (info["outcome"], info["is_success"]) == ("safe", False)
        assert info["ghosts"] == clean["ghosts"] + 1


@pytest.mark.usefixtures("small_suite")
def test_a_large_near_patch_raises_an_alarm_and_a_far_one_does_not() -> None:
    clean = {"source": "mixed", "count": 4}
    env = LidarSpoofingEnv(
        scenarios="mixed", validator={"name": "thresholds", "rate": 0.0}, clean=clean
    )
    env.reset(seed=0)
    far = env.step(env.coding.encode(LidarSpoofing(0.5, 0.5, 40.0, 0.65)))[-1]
    assert not far["alarm"]
    wall = LidarSpoofing(30.0, 8.0, 6.0, 0.0)
    sizes = {"widths": (0.5, 30.0), "heights": (0.5, 8.0)}
    env = LidarSpoofingEnv(scenarios="mixed", validator="thresholds", clean=clean, **sizes)
    env.reset(seed=0)
    *_, terminated, _, info = env.step(env.coding.encode(wall))
    assert (info["outcome"], info["alarm"], terminated) == ("unplanned", True, False)
    assert info["error"] > far["error"] + 0.3


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"distances": [0, 20]}, "distances"),
        ({"widths": [2, 1]}, "widths"),
        ({"heights": [1, float("nan")]}, "heights"),
        ({"bearings": [0.5]}, "bearings"),
        ({"price": float("inf")}, "price"),
    ],
)
def test_wrong_arguments_are_refused(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigurationError, match=message):
        LidarSpoofingEnv(**arguments)


def test_the_packages_network_may_be_the_victim(scenarios: str) -> None:
    env = LidarSpoofingEnv(scenarios=scenarios, detector="pixor", validator=None)
    env.reset(options=EMPTY_LANE)
    assert env.game.pipeline.detector.name == "pixor"
    assert np.isfinite(env.step(np.zeros(4))[0]).all()
