"""Agents are trained, stopped, gone on with, stored and loaded."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import count
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import torch
import yaml

from avsec_gym.agents import training
from avsec_gym.agents.agent_folder import CARD, CONFIG, WEIGHTS, load_agent, read_configuration
from avsec_gym.agents.checkpoint import CHECKPOINT, read_checkpoint
from avsec_gym.agents.configuration import AgentConfiguration, configuration_of
from avsec_gym.agents.learner import make_learner, make_policy, single
from avsec_gym.agents.training import TrainingSitting, train_agent
from avsec_gym.agents.yaml_files import read_yaml
from avsec_gym.errors import ConfigurationError, DataError

SCENES = {"scenarios": {"name": "layouts", "seed": 0, "count": 8}}
PPO = AgentConfiguration(
    "avsec/GhostObject-v1",
    "ppo",
    64,
    "PlacePolicy",
    4,
    SCENES,
    arguments={"n_steps": 8, "batch_size": 16, "n_epochs": 2},
)
SAC = AgentConfiguration(
    "avsec/GhostObject-v0",
    "sac",
    40,
    n_envs=2,
    env_kwargs=SCENES,
    arguments={
        "learning_starts": 8,
        "buffer_size": 30,
        "batch_size": 8,
        "policy_kwargs": {"net_arch": [8]},
    },
)


@pytest.mark.parametrize("algorithm", ["ppo", "sac"])
def test_a_policy_of_images_takes_the_weights_that_are_trained(algorithm: str) -> None:
    """Training has the colours of an image first, the environment last."""
    configuration = configuration_of("FaculaAttack-v0", algorithm, variant="images")
    learner = make_learner(configuration, 0)
    environment = single(configuration.env, configuration.env_kwargs)
    policy = make_policy(configuration, environment)
    policy.load_state_dict(learner.policy.state_dict())
    seen = environment.observation_space.sample()
    np.testing.assert_allclose(
        policy.predict(seen, deterministic=True)[0],
        learner.predict(seen, deterministic=True)[0],
        atol=1e-6,
    )


@pytest.mark.parametrize("configuration", [PPO, SAC], ids=["ppo", "sac"])
def test_a_training_goes_on_where_it_stopped(
    configuration: AgentConfiguration, tmp_path: Path
) -> None:
    half = train_agent(configuration, tmp_path, 3, TrainingSitting(32))
    assert (half.steps, half.finished) == (32, True)
    again = make_learner(configuration, 3)
    assert read_checkpoint(tmp_path, again).steps == 32
    # Weights, the averages of the optimiser and the replay buffer are those of the checkpoint.
    stored = load_agent(tmp_path).policy.state_dict()
    for name, value in again.policy.state_dict().items():
        assert torch.equal(value, stored[name]), name
    optimiser = again.policy.optimizer if configuration is PPO else again.actor.optimizer
    assert optimiser.state_dict()["state"][0]["exp_avg"].abs().sum() > 0
    if configuration is SAC:
        assert again.replay_buffer.size() == 15  # 30 for 2 environments; 16 were seen.
        assert again.replay_buffer.full
        assert again.log_ent_coef.item() != 0
    whole = train_agent(configuration, tmp_path, 3, TrainingSitting(64, resume=True))
    assert (whole.steps, whole.finished) == (64, True)
    assert whole.sha256 != half.sha256


def test_tensorboard_sees_a_training_in_all_its_sittings(tmp_path: Path) -> None:
    name = "tensorboard.backend.event_processing.event_accumulator"
    event_accumulator = pytest.importorskip(name)
    train_agent(PPO, tmp_path, 3, TrainingSitting(64))
    train_agent(PPO, tmp_path, 3, TrainingSitting(128, resume=True))
    found = event_accumulator.EventAccumulator(str(tmp_path / training.TENSORBOARD))
    found.Reload()
    assert {"rollout/ep_rew_mean", "train/loss"} <= set(found.Tags()["scalars"])
    steps = [event.step for event in found.Scalars("train/loss")]
    assert steps == sorted(set(steps))
    assert steps[0] <= 64 < steps[-1] <= 128


def test_time_is_up_and_nothing_is_lost(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # A clock that goes on by 10 ms whenever it is looked at, however busy the machine is.
    clock = SimpleNamespace(monotonic=partial(next, count(step=0.01)))
    monkeypatch.setattr("avsec_gym.agents.training.time", clock)
    card = train_agent(PPO, tmp_path, 0, TrainingSitting(10_000, minutes=1e-6))
    assert not card.finished
    assert card.steps == 0, "the first rollout had not begun"
    card = train_agent(PPO, tmp_path, 0, TrainingSitting(10_000, minutes=0.01, resume=True))
    assert not card.finished
    assert 0 < card.steps < 10_000
    assert card.steps % 32 == 0, "whole rollouts"
    more = train_agent(PPO, tmp_path, 0, TrainingSitting(card.steps + 32, resume=True))
    assert (more.steps, more.finished) == (card.steps + 32, True)


def test_an_interrupted_training_keeps_what_it_learned(tmp_path: Path) -> None:
    def interrupt(after: int) -> Callable[[int, int], None]:
        def shown(done: int, total: int) -> None:
            if done > after:
                raise KeyboardInterrupt

        return shown

    with pytest.raises(KeyboardInterrupt):
        train_agent(PPO, tmp_path, 0, TrainingSitting(640), interrupt(100))
    assert read_checkpoint(tmp_path, make_learner(PPO, 0)).steps == 96
    assert train_agent(PPO, tmp_path, 0, TrainingSitting(128, resume=True)).finished


def test_another_training_is_not_gone_on_with(tmp_path: Path) -> None:
    train_agent(PPO, tmp_path, 0, TrainingSitting(32))
    with pytest.raises(DataError, match="--resume"):
        train_agent(PPO, tmp_path, 0, TrainingSitting(32))
    with pytest.raises(DataError, match="differs in seed"):
        train_agent(PPO, tmp_path, 1, TrainingSitting(32, resume=True))
    other = replace(PPO, n_envs=5, arguments=PPO.arguments | {"gamma": 0.5})
    with pytest.raises(DataError, match="differs in gamma, n_envs"):
        train_agent(other, tmp_path, 0, TrainingSitting(32, resume=True))


@pytest.fixture(scope="module")
def trained(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("agent")
    train_agent(PPO, out, 0, TrainingSitting(32))
    return out


def test_a_loaded_agent_acts_like_the_trained_one(trained: Path) -> None:
    agent, env = load_agent(trained), single(PPO.env, SCENES)
    seen, _ = env.reset(seed=0)
    learner = make_learner(PPO, 0)
    read_checkpoint(trained, learner)
    expected = learner.predict(seen, deterministic=True)[0]
    assert np.array_equal(agent.predict(seen)[0], expected)
    assert agent.predict(np.stack([seen, seen]))[0].shape == (2, 16)
    assert agent.card.steps == 32
    assert agent.card.parameters == sum(v.numel() for v in learner.policy.parameters())


@pytest.mark.parametrize(
    ("name", "content", "problem"),
    [
        (WEIGHTS, b"\x80\x04K\x01.", "no sound one of safetensors"),  # A pickle.
        (WEIGHTS, None, "not there|no such|No such"),
        (CARD, b"{}", "lacks env"),
        (CONFIG, b"env: avsec/GhostObject-v9", "Did you mean"),
        (CONFIG, b"!!python/object/apply:os.getcwd []", "no sound YAML"),
        (CONFIG, b"env: avsec/GhostObject-v1\nalgorithm: luck\nseed: 0", "no algorithm 'luck'"),
    ],
)
def test_damaged_agents_are_refused(
    trained: Path, tmp_path: Path, name: str, content: bytes | None, problem: str
) -> None:
    for path in filter(Path.is_file, trained.iterdir()):
        (tmp_path / path.name).write_bytes(path.read_bytes())
    (tmp_path / name).unlink()
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(DataError, match=problem) as error:
        load_agent(tmp_path)
    assert name in str(error.value)
    assert "avsec agents train" in str(error.value) or content is None


@pytest.mark.parametrize(
    "wrong", ["{a: 1}", "[1]", "null", "true", "1.5", "-1", "x", "99999999999"]
)
def test_no_value_of_the_settings_can_be_anything(
    trained: Path, tmp_path: Path, wrong: str
) -> None:
    sound = read_yaml(trained / CONFIG, remedy="")
    for name in sound:
        lines = yaml.safe_dump({key: value for key, value in sound.items() if key != name})
        (tmp_path / CONFIG).write_text(f"{lines}{name}: {wrong}\n")
        with pytest.raises(DataError, match=r"config\.yml"):
            read_configuration(tmp_path)


def test_the_file_of_a_configuration_that_cannot_be_is_named(tmp_path: Path) -> None:
    path = tmp_path / "odd.yml"
    path.write_text(
        "avsec/GhostObject-v0:\n  n_timesteps: 10\n  env_kwargs: {scenarios: {name: \u202e}}\n"
    )
    odd = configuration_of("GhostObject-v0", "ppo", path)
    with pytest.raises(DataError, match=r"odd\.yml: The entry avsec/GhostObject-v0: "):
        train_agent(odd, tmp_path / "agent", 0, TrainingSitting(8))


def test_weights_of_another_agent_are_refused(trained: Path, tmp_path: Path) -> None:
    for path in filter(Path.is_file, trained.iterdir()):
        (tmp_path / path.name).write_bytes(path.read_bytes())
    card = json.loads((tmp_path / CARD).read_text())
    (tmp_path / CARD).write_text(json.dumps(card | {"sha256": "0" * 64}))
    with pytest.raises(DataError, match="not the one of its card"):
        load_agent(tmp_path)


def test_a_damaged_checkpoint_is_refused(tmp_path: Path) -> None:
    train_agent(PPO, tmp_path, 0, TrainingSitting(32))
    weights = (tmp_path / WEIGHTS).read_bytes()
    (tmp_path / CHECKPOINT).write_bytes(weights)
    with pytest.raises(DataError, match="of another configuration"):
        train_agent(PPO, tmp_path, 0, TrainingSitting(64, resume=True))


def test_arguments_that_do_not_fit_are_a_usage_error(tmp_path: Path) -> None:
    odd = replace(PPO, policy="CnnPolicy")
    with pytest.raises(ConfigurationError, match="does not fit"):
        train_agent(odd, tmp_path, 0, TrainingSitting(8))


def test_long_trainings_leave_checkpoints(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written: list[int] = []
    monkeypatch.setattr(training, "_SECONDS_BETWEEN_CHECKPOINTS", 0.0)
    monkeypatch.setattr(
        training, "write_checkpoint", lambda out, learner, progress: written.append(progress.steps)
    )
    train_agent(PPO, tmp_path, 0, TrainingSitting(96))
    assert written == [0, 32, 64, 96]
