"""`AimingPolicy`: where it aims does not depend on the order of the objects."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch
from scipy.stats import norm

from avsec_gym.agents.agent_folder import load_agent
from avsec_gym.agents.aimed_games import GAMES, AimedGame
from avsec_gym.agents.aiming_policy import AimedAction, AimingPolicy
from avsec_gym.agents.configuration import AgentConfiguration
from avsec_gym.agents.hiding_rules import hidden_at
from avsec_gym.agents.training import TrainingSitting, train_agent
from avsec_gym.errors import ConfigurationError

NAMES = list(GAMES)


def spaces(aim: AimedGame) -> tuple[gym.spaces.Box, gym.spaces.Box]:
    return tuple(gym.spaces.Box(-1.0, 1.0, (n,), np.float32) for n in (aim.observation, aim.action))  # type: ignore[return-value]


def policy(game: str, **named: Any) -> AimingPolicy:
    torch.manual_seed(0)
    return AimingPolicy(*spaces(GAMES[game]), lambda _: 1e-3, game=game, **named)


def observations(aim: AimedGame, count: int = 6) -> torch.Tensor:
    found = torch.rand((count, aim.observation), generator=torch.Generator().manual_seed(1))
    rows = found[:, aim.first : aim.first + aim.count * aim.size]
    rows.view(count, aim.count, aim.size)[:, 3:, 0] = 0.0
    found[:, aim.clock] = torch.arange(count) / aim.steps
    return found


@pytest.mark.parametrize("game", NAMES)
def test_the_order_of_the_objects_does_not_matter(game: str) -> None:
    aim, seen = GAMES[game], observations(GAMES[game])
    shuffled = seen.clone()
    end = aim.first + aim.count * aim.size
    rows = seen[:, aim.first : end].reshape(-1, aim.count, aim.size)
    shuffled[:, aim.first : end] = rows.flip(1).reshape(len(seen), -1)
    net = policy(game).action_net
    torch.testing.assert_close(net(seen), net(shuffled), atol=1e-5, rtol=1e-4)


@pytest.mark.parametrize("game", NAMES)
def test_places_without_an_object_draw_no_aim(game: str) -> None:
    """What stands in empty rows changes nothing, and with no object at all the aim is finite."""
    aim, seen = GAMES[game], observations(GAMES[game])
    changed = seen.clone()
    end = aim.first + aim.count * aim.size
    rows = changed[:, aim.first : end].view(len(seen), aim.count, aim.size)
    rows[:, 3:, 1:] += 1.0
    net = policy(game).action_net
    torch.testing.assert_close(net(seen), net(changed))
    rows[..., 0] = 0.0
    assert torch.isfinite(net(changed)).all()


def test_a_lone_object_is_aimed_at() -> None:
    aim = GAMES["closed_loop_attack"]
    net = AimedAction(aim)
    for value in net.whole.parameters():
        torch.nn.init.zeros_(value)
    seen = torch.zeros(1, aim.observation)
    seen[0, aim.first : aim.first + 3] = torch.tensor([1.0, 30 / 50, -4 / 20])
    found = net(seen)[0, list(aim.aimed)].detach().numpy()
    np.testing.assert_allclose(found, hidden_at(30.0, -4.0)[5:], atol=1e-5)


def test_steps_between_two_plans_are_told_apart() -> None:
    aim = GAMES["closed_loop_attack"]
    net = AimedAction(aim)
    seen = torch.zeros(80, aim.observation)
    seen[:, aim.clock] = 1.0 - torch.arange(80) / 80
    steps = net._step(seen).argmax(dim=1)
    assert (steps == (-torch.arange(80)) % 5).all()


def test_first_actions_scatter_as_asked() -> None:
    made = policy("closed_loop_attack", deviations=(0.1, 0.7))
    np.testing.assert_allclose(
        made.log_std.exp().detach(), [0.7, 0.7, 0.7, 0.7, 0.7, 0.1, 0.1], rtol=1e-6
    )


def test_an_attack_begins_mostly_off_in_whatever_it_sees() -> None:
    aim, made = GAMES["closed_loop_attack"], policy("closed_loop_attack")
    mean = made.action_net(torch.rand(200, aim.observation))[:, list(aim.switches)]
    off = norm.cdf(-mean.detach().numpy() / 0.6).mean()
    assert 0.7 < off < 0.95


def test_other_games_are_refused() -> None:
    with pytest.raises(ConfigurationError, match="game is one of closed_loop_attack"):
        AimingPolicy(*spaces(GAMES["facula_attack"]), lambda _: 1e-3, game="chess")
    with pytest.raises(ConfigurationError, match="177 numbers observed and 7 of an action"):
        AimingPolicy(*spaces(GAMES["facula_attack"]), lambda _: 1e-3)


def test_it_learns_and_comes_back(tmp_path: Path) -> None:
    configuration = AgentConfiguration(
        "avsec/ClosedLoopAttack-v0",
        "ppo",
        64,
        "AimingPolicy",
        4,
        {"scenarios": {"source": "layouts", "seed": 0, "count": 4}},
        arguments={"n_steps": 16, "batch_size": 32, "n_epochs": 2},
    )
    trained = train_agent(configuration, tmp_path, 3, TrainingSitting(2))
    assert trained.steps == 64
    agent = load_agent(tmp_path)
    seen = observations(GAMES["closed_loop_attack"]).numpy()
    actions, _ = agent.predict(seen)
    assert actions.shape == (6, 7)
    untrained = policy("closed_loop_attack").predict(seen, deterministic=True)[0]
    assert not np.allclose(actions, untrained)
