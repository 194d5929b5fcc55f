"""`AimingPolicy`: looks at each object by the same small network, and aims at one of them.

It reads the features of an observation, where an object is a row of numbers, and no pixel.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import gymnasium as gym
import torch
from stable_baselines3.common.policies import ActorCriticPolicy
from torch import nn

from avsec_gym.agents.aimed_games import GAMES, AimedGame
from avsec_gym.errors import ConfigurationError

_SHARPNESS = 4.0
"""What scores are multiplied by, so that the surest object gets nearly all of the aim early on."""
_MOSTLY_OFF = -0.5
"""The first mean of a switch."""
_FOUND = 4
"""Numbers that are found out about each object, the first its score."""


class AimedAction(nn.Module):
    """The mean action, from scores of the objects.

    Args:
        game: Where objects and places are.
        hidden: Width of all hidden layers.
    """

    def __init__(self, game: AimedGame, hidden: int = 64) -> None:
        super().__init__()
        self.game = game
        others = game.observation - game.count * game.size + game.period
        self.each = nn.Sequential(
            nn.Linear(game.size + others, hidden),
            nn.ReLU(),
            nn.Linear(hidden, hidden),
            nn.ReLU(),
            nn.Linear(hidden, _FOUND),
        )
        last = nn.Linear(hidden, game.action)
        # Mostly off at first, so that what there is lasts until it is seen what it is good for.
        with torch.no_grad():
            last.bias[list(game.switches)] = _MOSTLY_OFF
        self.whole = nn.Sequential(nn.Linear(others + _FOUND, hidden), nn.Tanh(), last)

    def forward(self, observations: torch.Tensor) -> torch.Tensor:
        """Mean actions of observations (B, M), shape (B, A)."""
        game, end = self.game, self.game.first + self.game.count * self.game.size
        rows: torch.Tensor = game.objects(observations)
        others = torch.cat(
            [observations[:, : game.first], observations[:, end:], self._step(observations)], dim=1
        )
        # Each object by itself, beside all that is no object.
        beside = others[:, None].expand(-1, game.count, -1)
        found = self.each(torch.cat([rows, beside], dim=-1))
        # The objects' shares of the attention; zeros where there is none.
        there = rows[..., 0] > 0
        scores = (_SHARPNESS * found[..., 0]).masked_fill(~there, -1e4)
        share = (scores.softmax(dim=1) * there)[..., None]
        # The place is that of the object with the highest score, or nearly; the rest of the action
        # is no object's, and is added to the place as what is aimed beside it.
        slope, offset = observations.new_tensor(game.line).T
        aimed = (share * rows[..., list(game.seen)]).sum(dim=1) * slope + offset
        action = self.whole(torch.cat([others, (share * found).sum(dim=1)], dim=1))
        return action.index_add(1, torch.tensor(game.aimed), aimed)

    def _step(self, observations: torch.Tensor) -> torch.Tensor:
        """Which step of the car's period it is, one-hot, shape (B, period)."""
        game = self.game
        left = (observations[:, game.clock] * game.steps).round().long()
        return nn.functional.one_hot(left % game.period, game.period).to(observations)


class AimingPolicy(ActorCriticPolicy):
    """The mean action is that of `AimedAction`; the value is learned from the whole observation.

    Observations are features, also where the attack is one on images.

    Args:
        observation_space: The observation space of the game.
        action_space: Its action space.
        lr_schedule: The learning rate by the share of the training that is left.
        game: One of `GAMES`.
        deviations: Standard deviations of the first actions: of a place, and of all else.
        net_arch: Widths of the hidden layers of the value alone.
        named: Other arguments of stable-baselines3's `ActorCriticPolicy`.

    Raises:
        ConfigurationError: There is no such game, or its spaces have another size.
    """

    def __init__(
        self,
        observation_space: gym.spaces.Box,
        action_space: gym.spaces.Box,
        lr_schedule: Callable[[float], float],
        *,
        game: str = "closed_loop_attack",
        deviations: Sequence[float] = (0.2, 0.6),
        net_arch: Sequence[int] = (128, 128),
        **named: Any,
    ) -> None:
        if game not in GAMES:
            raise ConfigurationError(f"game is one of {', '.join(GAMES)}, got {game!r}")
        self.game, self._deviations = GAMES[game], deviations
        arch = {"pi": [], "vf": list(net_arch)}
        super().__init__(observation_space, action_space, lr_schedule, net_arch=arch, **named)

    def _build(self, lr_schedule: Callable[[float], float]) -> None:
        super()._build(lr_schedule)
        game = self.game
        if not game.fits(self.observation_space, self.action_space):
            raise ConfigurationError(
                f"this game has {game.observation} numbers observed and {game.action} of an action,"
                " the environment others: its attack is another than the default"
            )
        self.action_net = AimedAction(game)
        place, others = self._deviations
        with torch.no_grad():
            self.log_std.fill_(math.log(others))
            self.log_std[list(game.aimed)] = math.log(place)
        optimiser: Any = self.optimizer_class
        self.optimizer = optimiser(self.parameters(), lr=lr_schedule(1), **self.optimizer_kwargs)
