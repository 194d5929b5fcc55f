"""What an algorithm keeps to learn from is refused where it would fill the memory."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest
from stable_baselines3.common.buffers import DictReplayBuffer, ReplayBuffer, RolloutBuffer

from avsec_gym.agents import kept_steps
from avsec_gym.agents.configuration import AgentConfiguration, configuration_of
from avsec_gym.agents.kept_steps import bytes_of, check_kept_steps
from avsec_gym.agents.training import TrainingSitting, train_agent
from avsec_gym.errors import ConfigurationError, DataError

IMAGE = gym.spaces.Box(0, 255, (3, 40, 50), np.uint8)
BOTH = gym.spaces.Dict({"image": IMAGE, "scene": gym.spaces.Box(-1, 1, (7,), np.float32)})
ACTION = gym.spaces.Box(-1, 1, (2,), np.float32)


@pytest.mark.parametrize(
    "space", [IMAGE, BOTH, gym.spaces.Discrete(5), gym.spaces.MultiBinary(9)], ids=str
)
def test_bytes_of_observations_are_those_of_the_buffer(space: gym.Space) -> None:
    if isinstance(space, gym.spaces.Dict):
        both = DictReplayBuffer(10, space, ACTION)
        arrays = [*both.observations.values(), *both.next_observations.values()]
    else:
        buffer = ReplayBuffer(10, space, ACTION)
        arrays = [buffer.observations, buffer.next_observations]
    assert sum(array.nbytes for array in arrays) == 10 * 2 * bytes_of(space)


def test_a_buffer_is_refused_from_the_first_step_that_does_not_fit(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(kept_steps, "half_of_memory", lambda: 2.0 * bytes_of(IMAGE) * 1000)
    sac = AgentConfiguration("avsec/GhostObject-v0", "sac", 10)
    check_kept_steps(sac, {"buffer_size": 1000}, IMAGE)
    with pytest.raises(ConfigurationError, match=r"sac keeps buffer_size = 1,001 .*0\.0 GB"):
        check_kept_steps(sac, {"buffer_size": 1001}, IMAGE)
    with pytest.raises(ConfigurationError, match="buffer_size = 1,000,000"):
        check_kept_steps(sac, {}, IMAGE)


def test_what_a_rollout_keeps_of_all_environments_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    rollout = RolloutBuffer(32, IMAGE, ACTION, n_envs=4)
    rollout.reset()
    monkeypatch.setattr(kept_steps, "half_of_memory", lambda: float(rollout.observations.nbytes))
    ppo = AgentConfiguration("avsec/GhostObject-v0", "ppo", 10, n_envs=4)
    check_kept_steps(ppo, {"n_steps": 32}, IMAGE)
    for arguments, said in (({"n_steps": 33}, "33"), ({}, "2,048")):
        with pytest.raises(ConfigurationError, match=f"n_steps = {said} "):
            check_kept_steps(ppo, arguments, IMAGE)
    with pytest.raises(ConfigurationError, match="n_steps"):
        check_kept_steps(replace(ppo, n_envs=5), {"n_steps": 32}, IMAGE)


@pytest.mark.parametrize("short", ["half", "none"])
def test_a_file_without_its_buffer_s_size_is_refused_before_the_memory_is_taken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, short: str
) -> None:
    """As an entry does that was cut off before it: the default is a million steps."""
    file = tmp_path / "sac.yml"
    file.write_text(
        "avsec/GhostObject-v0:\n  n_timesteps: 8\n  policy: MlpPolicy\n  env_kwargs:"
        " {scenarios: {name: layouts, seed: 0, count: 2}}\n"
    )
    if short == "half":
        monkeypatch.setattr(kept_steps, "half_of_memory", lambda: 1e6)
    else:

        def no_memory(*_: object, **__: object) -> None:
            raise MemoryError("Unable to allocate 3 GiB")

        monkeypatch.setattr(ReplayBuffer, "__init__", no_memory)
    configuration = configuration_of("avsec/GhostObject-v0", "sac", file)
    with pytest.raises(DataError, match=r"sac\.yml.*(buffer_size|allocate)"):
        train_agent(configuration, tmp_path / "out", 0, TrainingSitting(8))
