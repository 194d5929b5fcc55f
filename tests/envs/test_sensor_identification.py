"""`avsec/SensorIdentification-v0`: what the validator is told, and what it is paid for."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from stable_baselines3.common.evaluation import evaluate_policy

import avsec_gym  # noqa: F401
from avsec_gym.envs.sensor_identification import SensorIdentificationEnv
from avsec_gym.envs.validator_policy import ValidatorPolicy
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.sensor_system import KITTI_SYSTEM, SensorSystem
from avsec_gym.validation.detection import LIDAR_AND_TWO_CAMERAS
from avsec_gym.validation.evidence.disparity_error import DisparityErrors
from avsec_gym.validation.evidence.disparity_maps import DisparityMaps
from avsec_gym.validation.state_posterior import SensorStatus
from avsec_gym.validation.validator import Validation

pytestmark = pytest.mark.usefixtures("small_suite")

ID = "avsec/SensorIdentification-v0"


class Comparing:
    """A validator that compares what it is shown with the frame as it was recorded."""

    name = "comparing"
    system: SensorSystem = KITTI_SYSTEM

    def __init__(self, env: gym.Env[Any, Any]) -> None:
        played: Any = env.unwrapped
        self.clean = {recorded.id: recorded.frame() for recorded in played.frames}
        self.env = played

    def validate(self, frame: SensorFrame) -> Validation:
        clean = self.clean[self.env._played.id]
        changed = {"lidar": not np.array_equal(frame.points, clean.points)}
        for camera in self.system.cameras:
            changed[camera] = not np.array_equal(frame.image(camera), clean.image(camera))
        said = {
            sensor: SensorStatus.ATTACKED if flag else SensorStatus.SOUND
            for sensor, flag in changed.items()
        }
        return Validation(
            any(changed.values()), said, DisparityErrors(DisparityMaps(frame, self.system))
        )


def test_exactly_the_attacked_sensors_change_and_a_policy_that_knows_them_always_wins() -> None:
    env = gym.make(ID, most=3)
    rewards, _ = evaluate_policy(
        ValidatorPolicy(Comparing(env), env), env, 8, return_episode_rewards=True, warn=False
    )
    assert rewards == [1.0] * 8


def test_only_the_exact_answer_is_paid_for() -> None:
    env = gym.make(ID)
    options = {"attacked": ["lidar", 3]}
    for answer, reward, counts in (
        ([1, 0, 1, 0], 1.0, (2, 0, 0)),
        ([1, 0, 0, 0], 0.0, (1, 1, 0)),
        ([1, 1, 1, 0], 0.0, (2, 0, 1)),
        ([0, 0, 0, 0], 0.0, (0, 2, 0)),
    ):
        _, info = env.reset(seed=0, options=options)
        assert info["attacked"] == "", "it is not shown before the answer"
        _, paid, terminated, _, info = env.step(np.array(answer, np.int8))
        assert (paid, terminated, info["is_success"]) == (reward, True, reward == 1)
        assert (info["hits"], info["missed"], info["false_alarms"]) == counts
        assert info["attacked"] == "lidar 3"
    env.reset(seed=0, options={"attacked": []})
    assert env.step(np.zeros(4, np.int8))[1] == 1.0


def test_what_is_told_is_what_the_sensors_say_of_each_other() -> None:
    """By hand: errors of all triples, holes and brightness of all pairs of cameras."""
    env = SensorIdentificationEnv()
    seen, _ = env.reset(seed=0, options={"attacked": [2]})
    maps = DisparityMaps(env.frame, KITTI_SYSTEM)
    errors = DisparityErrors(maps)
    triples = [(0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)]
    pairs = [(1, 2), (1, 3), (2, 3)]
    expected = [errors[triple].error for triple in triples]
    expected += [errors[triple].densest for triple in triples[:3]]
    expected += [1 - maps[pair].valid.mean() for pair in pairs]
    expected += [maps.brightness(pair).brighter for pair in pairs]
    expected += [maps.brightness(pair).darker for pair in pairs]
    np.testing.assert_allclose(seen, expected, atol=1e-6)


def test_attacks_are_drawn_as_told() -> None:
    env = SensorIdentificationEnv(unattacked=0.5, most=2)
    drawn = []
    for seed in range(40):
        env.reset(seed=seed)
        drawn.append(int(env._attacked.sum()))
    assert set(drawn) == {0, 1, 2}
    assert 10 <= drawn.count(0) <= 30
    env = SensorIdentificationEnv(unattacked=1.0)
    env.reset(seed=0)
    assert not env._attacked.any()
    assert max(map(len, SensorIdentificationEnv().cases)) == 1, "n - 2 of four"


def test_frames_to_train_on_and_others_to_judge_by() -> None:
    first = SensorIdentificationEnv(scenarios={"source": "raw", "count": 3}).frames
    rest = SensorIdentificationEnv(scenarios={"source": "raw", "first": 3}).frames
    assert [len(first), len(rest)] == [3, 1]
    assert not {frame.id for frame in first} & {frame.id for frame in rest}
    with pytest.raises(ConfigurationError, match="none is left"):
        _ = SensorIdentificationEnv(scenarios={"source": "raw", "first": 4}).frames


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"sensors": ["lidar", 2]}, "3 to 16 sensors"),
        ({"clean": 1.5}, "clean"),
        ({"most": 0}, "most"),
        ({"most": 5}, "most"),
        ({"depth": 3}, "depth"),
        ({"planner": "gbfs"}, "no car drives .* planner would never"),
        ({"classifier": "small", "response": "drop"}, "classifier and response would never"),
    ],
)
def test_wrong_arguments_are_refused(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigurationError, match=message):
        SensorIdentificationEnv(**arguments)


def test_what_is_no_sensor_no_recording_and_no_flag_is_refused() -> None:
    with pytest.raises(ConfigurationError, match="source, first and count"):
        SensorIdentificationEnv(scenarios={"folder": "raw"}).reset(seed=0)
    for wrong in (3, {"first": "a"}, {"first": True}, {"count": 0}):
        with pytest.raises(ConfigurationError, match=r"scenarios are|first takes|count takes"):
            SensorIdentificationEnv(scenarios=wrong).reset(seed=0)
    env = SensorIdentificationEnv()
    with pytest.raises(ConfigurationError, match="lidar, 1, 3, 2"):
        env.reset(seed=0, options={"attacked": [0]})
    env.reset(seed=0)
    with pytest.raises(ConfigurationError, match="0 and 1"):
        env.step(np.full(4, 0.5))


def test_a_validator_of_other_sensors_is_refused() -> None:
    env = SensorIdentificationEnv()
    validator = Comparing(env)
    validator.system = LIDAR_AND_TWO_CAMERAS
    with pytest.raises(ConfigurationError, match="the validator judges"):
        ValidatorPolicy(validator, env)
