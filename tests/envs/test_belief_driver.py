"""What drivers that read the car's belief have in common."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import pytest

from avsec_gym.envs.idm_driver import IdmDriver
from avsec_gym.envs.planner_driver import PlannerDriver
from avsec_gym.errors import ConfigurationError


@pytest.mark.parametrize("driver", [IdmDriver, PlannerDriver])
def test_meta_actions_are_refused(driver: Any) -> None:
    config = {"action": {"type": "DiscreteMetaAction"}}
    env = gym.make("avsec_gym:avsec/ClosedLoop-v0", config=config)
    with pytest.raises(ConfigurationError, match=f"{driver.__name__} drives by continuous actions"):
        driver(env)


@pytest.mark.parametrize("driver", [IdmDriver, PlannerDriver])
def test_a_driver_that_has_driven_begins_another_drive_as_a_new_one_does(driver: Any) -> None:
    env = gym.make("avsec_gym:avsec/ClosedLoop-v0", scenarios="layouts")
    used = driver(env)
    observation, _ = env.reset(seed=1)
    for _ in range(3):
        observation, *_ = env.step(used.predict(observation)[0])
    observation, _ = env.reset(seed=2)
    again, _ = used.predict(observation)
    observation, _ = env.reset(seed=2)
    new, _ = driver(env).predict(observation)
    assert again.tolist() == new.tolist()
    assert again.shape == (2,)
    assert used.predict(observation[None])[0].shape == (1, 2)
