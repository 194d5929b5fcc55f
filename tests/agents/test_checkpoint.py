"""Checkpoints that are damaged: refused before a step is taken."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import torch
from safetensors.torch import load_file, save_file
from torch import Tensor

from avsec_gym.agents.checkpoint import CHECKPOINT, misfit, read_checkpoint
from avsec_gym.agents.configuration import AgentConfiguration
from avsec_gym.agents.learner import make_learner
from avsec_gym.agents.training import TrainingSitting, train_agent
from avsec_gym.errors import ConfigurationError, DataError

SCENES = {"scenarios": {"name": "layouts", "seed": 0, "count": 4}}
NARROW = {"policy_kwargs": {"net_arch": [8]}}
SAC = AgentConfiguration(
    "avsec/GhostObject-v0", "sac", 40, n_envs=2, env_kwargs=SCENES,
    arguments={"learning_starts": 8, "buffer_size": 30, "batch_size": 8, **NARROW},
)  # fmt: skip
PPO = AgentConfiguration(
    "avsec/GhostObject-v0", "ppo", 32, n_envs=2, env_kwargs=SCENES,
    arguments={"n_steps": 8, "batch_size": 8, "n_epochs": 1, **NARROW},
)  # fmt: skip
Trained = tuple[AgentConfiguration, Path]
DAMAGES: dict[str, Callable[[Tensor], Tensor]] = {
    "not a number": lambda value: torch.full_like(value.double(), torch.nan),
    "without an end": lambda value: torch.full_like(value.double(), torch.inf),
    "complex": lambda value: value.to(torch.complex64),
    "flags": lambda value: value[None].bool(),
    "one more axis": lambda value: value[None].repeat(2, *[1] * value.dim()),
    "nothing": lambda value: torch.zeros(0, dtype=value.dtype),
}


@pytest.fixture(scope="module", params=[PPO, SAC], ids=["ppo", "sac"])
def trained(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> tuple[AgentConfiguration, Path]:
    out = tmp_path_factory.mktemp("agent")
    train_agent(request.param, out, 0, TrainingSitting(16))
    return request.param, out


def test_each_tensor_is_what_the_learner_has_there(
    trained: Trained,
) -> None:
    configuration, out = trained
    learner = make_learner(configuration, 0)
    sound = load_file(out / CHECKPOINT)
    assert misfit(sound, learner) is None
    for name, value in sound.items():
        for what, damage in DAMAGES.items():
            problem = misfit({**sound, name: damage(value)}, learner)
            assert problem is not None, (name, what)
            assert name in problem
        lacking = {key: own for key, own in sound.items() if key != name}
        assert name in str(misfit(lacking, learner)), name
        if value.is_floating_point():
            for number, what in (
                (torch.nan, "not fin"),
                (torch.inf, "not fin"),
                (1e38, "diverged"),
            ):
                full = torch.full_like(value, number)
                if value.numel():
                    assert what in str(misfit({**sound, name: full}, learner)), name
    assert "none of its" in str(misfit({**sound, "policy/more": torch.zeros(2)}, learner))
    assert "no time" in str(misfit({**sound, "progress/steps": torch.tensor(-1)}, learner))


def test_squares_and_counters_are_not_negative(trained: Trained) -> None:
    configuration, out = trained
    learner, sound = make_learner(configuration, 0), load_file(out / CHECKPOINT)
    squares = [name for name in sound if name.endswith(("/exp_avg_sq", "/step"))]
    assert squares
    for name in squares:
        wrong = {**sound, name: torch.full_like(sound[name], -1.0)}
        assert "below 0" in str(misfit(wrong, learner)), name


def test_places_in_the_buffer_are_places(tmp_path: Path) -> None:
    train_agent(SAC, tmp_path, 0, TrainingSitting(16))
    learner, sound = make_learner(SAC, 0), load_file(tmp_path / CHECKPOINT)
    for place in ([15, 0], [-1, 0], [2**62, 1], [3, 2]):
        position = torch.tensor(place)
        assert "place" in str(misfit({**sound, "replay/position": position}, learner)), place
    # A place that the rows do not reach.
    moved = {**sound, "replay/position": torch.tensor([12, 0])}
    assert "replay/" in str(misfit(moved, learner))


def test_the_file_is_named(trained: Trained) -> None:
    configuration, out = trained
    sound = load_file(out / CHECKPOINT)
    save_file({**sound, "progress/seconds": torch.tensor(torch.nan).double()}, out / CHECKPOINT)
    with pytest.raises(DataError, match=r"checkpoint\.safetensors: .*progress/seconds holds"):
        read_checkpoint(out, make_learner(configuration, 0))
    save_file(sound, out / CHECKPOINT)


@pytest.mark.parametrize("configuration", [PPO, SAC], ids=["ppo", "sac"])
def test_a_training_that_diverges_ends_by_saying_so(
    configuration: AgentConfiguration, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def spoilt(learner: Any, *_: Any, **__: Any) -> None:
        with torch.no_grad():
            for value in learner.policy.parameters():
                value.fill_(torch.nan)

    kind = type(make_learner(configuration, 0))
    monkeypatch.setattr(kind, "train", spoilt)
    with pytest.raises(ConfigurationError, match=f"{tmp_path} has diverged"):
        train_agent(configuration, tmp_path, 0, TrainingSitting(40))
    assert not (tmp_path / CHECKPOINT).exists(), "nothing to go on with"
