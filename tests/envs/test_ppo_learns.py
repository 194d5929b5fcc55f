"""PPO of stable-baselines3 learns in every environment of the catalogue, in short form."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.monitor import Monitor

from tests.envs.test_catalogue import CONNECTED, IDS, arguments

STEPS = 32
"""Of the 1,000 that each has to run: two rollouts, both learned from."""
CHEAP: dict[str, dict[str, Any]] = {
    "avsec/GhostObject-v0": {"scenarios": {"name": "layouts", "count": 8}},
    "avsec/GhostObject-v1": {"scenarios": {"name": "layouts", "count": 8}},
    "avsec/DetectorBenchmark-v0": {"observation": "thumbnails"},
    "avsec/ClosedLoop-v0": {"scenarios": {"source": "layouts", "count": 2}, "duration": 1.0},
    "avsec/ClosedLoopAttack-v0": {"scenarios": {"source": "layouts", "count": 1}},
}
"""What differs from the arguments of the catalogue's tests."""
RENDERED = {"avsec/DetectorBenchmark-v0", "avsec/SensorIdentification-v0", *CONNECTED}
"""Plays in a suite that is rendered first; the other attackers' frames are drawn in no time."""


def listed(id: str) -> Any:
    """The id, slow where sensors are rendered."""
    return pytest.param(id, marks=[pytest.mark.slow] if id in RENDERED else [])


@pytest.mark.parametrize("id", [listed(id) for id in IDS])
def test_ppo_learns_in_every_environment(id: str, request: pytest.FixtureRequest) -> None:
    if id in RENDERED:
        request.getfixturevalue("small_suite")
    env = Monitor(gym.make(id, **(arguments(id) | CHEAP.get(id, {}))))
    has_images = isinstance(env.observation_space, gym.spaces.Dict)
    policy = "MultiInputPolicy" if has_images else "MlpPolicy"
    model = PPO(policy, env, n_steps=STEPS // 2, batch_size=8, n_epochs=1, seed=0)
    before = {name: value.clone() for name, value in model.policy.state_dict().items()}
    model.learn(STEPS)
    after = model.policy.state_dict()
    assert model.num_timesteps == STEPS
    assert all(torch.isfinite(value).all() for value in after.values())
    changed = {name.split(".")[0] for name in after if not torch.equal(before[name], after[name])}
    assert {"action_net", "value_net", "mlp_extractor"} <= changed
    assert np.isfinite(env.get_episode_rewards()).all()
    observation, _ = env.reset(seed=0)
    action, _ = model.predict(observation, deterministic=True)
    assert env.action_space.contains(action)
    env.close()
